// Build, then trace, on one queue and in device memory: triangles that move, their tree and a picture's rays follow
// each other without passing through the host. Prints the last picture in letters.

#include <CL/cl.h>

#include <algorithm>
#include <clbvh/clbvh.hpp>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr std::uint32_t kSide = 100;                // quads along each side of the surface
constexpr std::uint32_t kWidth = 64, kHeight = 24;  // of the picture

void check(cl_int status, const char* call) {
    if (status != CL_SUCCESS) {
        throw std::runtime_error(std::string(call) + " failed with OpenCL error " + std::to_string(status));
    }
}

clbvh::Mesh surface(float time) {
    clbvh::Mesh mesh;
    for (std::uint32_t i = 0; i < (kSide + 1) * (kSide + 1); ++i) {
        const std::uint32_t row = i / (kSide + 1), column = i % (kSide + 1);
        const auto x = static_cast<float>(column), y = static_cast<float>(row);
        mesh.vertices.push_back({x, y, 6.0f * std::sin(0.15f * x + time) * std::cos(0.1f * y)});
    }
    for (std::uint32_t row = 0; row < kSide; ++row) {
        for (std::uint32_t column = 0; column < kSide; ++column) {
            const std::uint32_t corner = row * (kSide + 1) + column;
            mesh.triangles.push_back({corner, corner + 1, corner + kSide + 1});
            mesh.triangles.push_back({corner + 1, corner + kSide + 2, corner + kSide + 1});
        }
    }
    return mesh;
}

std::vector<clbvh::Ray> picture_rays() {
    std::vector<clbvh::Ray> rays;
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
        const std::uint32_t row = i / kWidth, column = i % kWidth;
        clbvh::Ray ray;
        ray.origin = {50.0f, -40.0f, 40.0f};
        ray.direction = {static_cast<float>(column) / kWidth - 0.5f, 1.0f, -0.2f - static_cast<float>(row) / kHeight};
        rays.push_back(ray);
    }
    return rays;
}

// The buffers that all frames share. The context and the queue are the library's here, and may be anybody's.
class Frames {
public:
    explicit Frames(const clbvh::Context& context)
        : queue_(context.opencl_queue()),
          opencl_(context.opencl_context()),
          builder_("plocpp-two-level", context),
          tracer_(context) {
        const clbvh::Mesh mesh = surface(0.0f);
        const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
        const clbvh::DeviceBuildSizes build_sizes = builder_.sizes(count);
        scene_.triangles.count = count;
        scene_.triangles.vertices = make_buffer(mesh.vertices.size() * sizeof(clbvh::Vec3));
        scene_.triangles.indices = make_buffer(count * sizeof(clbvh::Triangle));
        tree_ = {make_buffer(build_sizes.nodes), make_buffer(build_sizes.primitive_ids), {}};
        build_scratch_ = make_buffer(build_sizes.scratch);
        scene_.bvh = clbvh::DeviceBvh::of(tree_, count);

        const clbvh::DeviceTraceSizes trace_sizes = tracer_.sizes(scene_.bvh);
        scene_.layout = make_buffer(trace_sizes.layout);
        rays_.count = kWidth * kHeight;
        rays_.rays = make_buffer(rays_.count * sizeof(clbvh::Ray));
        rays_.results = make_buffer(rays_.count * sizeof(clbvh::Hit));
        rays_.scratch = make_buffer(trace_sizes.scratch);
        write(scene_.triangles.indices, mesh.triangles);
        write(rays_.rays, picture_rays());
    }
    Frames(const Frames&) = delete;
    Frames& operator=(const Frames&) = delete;
    ~Frames() {
        for (cl_mem buffer : buffers_)
            clReleaseMemObject(buffer);
    }

    // Moves the surface; enqueues its tree, a traversal layout of both, and the rays.
    void enqueue(float time) {
        write(scene_.triangles.vertices, surface(time).vertices);
        builder_.enqueue(queue_, scene_.triangles, build_scratch_, tree_);
        tracer_.enqueue_layout(queue_, scene_);
        tracer_.enqueue_closest(queue_, scene_, rays_);
    }

    [[nodiscard]] std::vector<clbvh::Hit> read_hits() const {
        std::vector<clbvh::Hit> hits(rays_.count);
        check(clEnqueueReadBuffer(queue_, rays_.results.buffer, CL_TRUE, 0, hits.size() * sizeof(clbvh::Hit),
                                  hits.data(), 0, nullptr, nullptr),
              "clEnqueueReadBuffer");
        return hits;
    }

private:
    clbvh::DeviceSpan make_buffer(std::size_t bytes) {
        cl_int status = CL_SUCCESS;
        buffers_.push_back(clCreateBuffer(opencl_, CL_MEM_READ_WRITE, bytes, nullptr, &status));
        check(status, "clCreateBuffer");
        return {buffers_.back(), 0};
    }

    template <typename T>
    void write(const clbvh::DeviceSpan& to, const std::vector<T>& values) {
        check(clEnqueueWriteBuffer(queue_, to.buffer, CL_TRUE, to.offset, values.size() * sizeof(T), values.data(), 0,
                                   nullptr, nullptr),
              "clEnqueueWriteBuffer");
    }

    cl_command_queue queue_;
    cl_context opencl_;
    clbvh::DeviceBuilder builder_;
    clbvh::DeviceTracer tracer_;
    std::vector<cl_mem> buffers_;
    clbvh::DeviceScene scene_;
    clbvh::DeviceResult tree_;
    clbvh::DeviceSpan build_scratch_;
    clbvh::DeviceRays rays_;
};

void print(const std::vector<clbvh::Hit>& hits) {
    const std::string letters = "@%#*+=-:.";
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const auto depth = static_cast<std::size_t>(hits[i] ? (hits[i].t - 30.0f) / 12.0f : 0.0f);
        std::cout << (hits[i] ? letters[std::min(depth, letters.size() - 1)] : ' ');
        if (i % kWidth == kWidth - 1) std::cout << '\n';
    }
}

}  // namespace

int main() {
    try {
        Frames frames(clbvh::Context::open());
        for (int frame = 0; frame < 5; ++frame)
            frames.enqueue(0.3f * static_cast<float>(frame));
        print(frames.read_hits());
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "trace_on_queue: " << error.what() << '\n';
        return 1;
    }
}
