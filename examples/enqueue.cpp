// Trees over triangles that are in device memory already, built on the program's own queue: one tree a frame, without
// an allocation or a wait between them.

#include <CL/cl.h>

#include <clbvh/clbvh.hpp>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr std::uint32_t kSide = 100;  // quads along each side of the surface

void check(cl_int status, const char* call) {
    if (status != CL_SUCCESS) {
        throw std::runtime_error(std::string(call) + " failed with OpenCL error " + std::to_string(status));
    }
}

// The memory that frames share; the context and the queue are the library's here, and may be anybody's.
class Frames {
public:
    explicit Frames(const clbvh::Context& context)
        : queue_(context.opencl_queue()), opencl_(context.opencl_context()), builder_("plocpp-two-level", context) {
        for (std::uint32_t row = 0; row < kSide; ++row) {
            for (std::uint32_t column = 0; column < kSide; ++column) {
                const std::uint32_t corner = row * (kSide + 1) + column;
                mesh_.triangles.push_back({corner, corner + 1, corner + kSide + 1});
                mesh_.triangles.push_back({corner + 1, corner + kSide + 2, corner + kSide + 1});
            }
        }
        mesh_.vertices.resize(std::size_t{kSide + 1} * (kSide + 1));
        const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
        const clbvh::DeviceBuildSizes sizes = builder_.sizes(count);
        triangles_.count = count;
        triangles_.vertices = {make_buffer(mesh_.vertices.size() * sizeof(clbvh::Vec3))};
        triangles_.indices = {make_buffer(count * sizeof(clbvh::Triangle))};
        scratch_ = {make_buffer(sizes.scratch)};
        result_ = {{make_buffer(sizes.nodes)}, {make_buffer(sizes.primitive_ids)}, {}};
        write(triangles_.indices, mesh_.triangles);
    }
    Frames(const Frames&) = delete;
    Frames& operator=(const Frames&) = delete;
    ~Frames() {
        for (cl_mem buffer : buffers_)
            clReleaseMemObject(buffer);
    }

    // Moves the surface and enqueues its tree; `event` is complete when the tree is.
    void enqueue(float time, cl_event* event) {
        for (std::uint32_t i = 0; i < mesh_.vertices.size(); ++i) {
            const std::uint32_t row = i / (kSide + 1), column = i % (kSide + 1);
            const auto x = static_cast<float>(column), y = static_cast<float>(row);
            mesh_.vertices[i] = {x, y, std::sin(0.1f * x + time) * std::cos(0.2f * y)};
        }
        write(triangles_.vertices, mesh_.vertices);
        builder_.enqueue(queue_, triangles_, scratch_, result_, {}, event);
    }

    // Reads the tree when `event` is complete. Other kernels would simply wait for the event.
    clbvh::Bvh read(cl_event event) const {
        clbvh::Bvh bvh;
        bvh.primitive_count = triangles_.count;
        bvh.nodes.resize(2 * std::size_t{triangles_.count});
        bvh.primitive_ids.resize(triangles_.count);
        check(clEnqueueReadBuffer(queue_, result_.nodes.buffer, CL_TRUE, 0, bvh.nodes.size() * sizeof(clbvh::Node),
                                  bvh.nodes.data(), 1, &event, nullptr),
              "clEnqueueReadBuffer");
        check(clEnqueueReadBuffer(queue_, result_.primitive_ids.buffer, CL_TRUE, 0,
                                  bvh.primitive_ids.size() * sizeof(std::uint32_t), bvh.primitive_ids.data(), 0,
                                  nullptr, nullptr),
              "clEnqueueReadBuffer");
        return bvh;
    }

    [[nodiscard]] const clbvh::Mesh& mesh() const { return mesh_; }

private:
    cl_mem make_buffer(std::size_t bytes) {
        cl_int status = CL_SUCCESS;
        buffers_.push_back(clCreateBuffer(opencl_, CL_MEM_READ_WRITE, bytes, nullptr, &status));
        check(status, "clCreateBuffer");
        return buffers_.back();
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
    clbvh::Mesh mesh_;
    std::vector<cl_mem> buffers_;
    clbvh::DeviceTriangles triangles_;
    clbvh::DeviceSpan scratch_;
    clbvh::DeviceResult result_;
};

}  // namespace

int main() {
    try {
        Frames frames(clbvh::Context::open());
        for (int frame = 0; frame < 5; ++frame) {
            cl_event built = nullptr;
            frames.enqueue(0.3f * static_cast<float>(frame), &built);
            const clbvh::Bvh bvh = frames.read(built);
            clReleaseEvent(built);
            const clbvh::ValidationReport report = clbvh::validate(bvh, frames.mesh());
            if (!report) throw std::runtime_error("broken tree: " + report.error);
            std::cout << "frame " << frame << ": SAH cost " << clbvh::sah_cost(bvh) << '\n';
        }
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "enqueue: " << error.what() << '\n';
        return 1;
    }
}
