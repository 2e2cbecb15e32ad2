// A program that has its own OpenCL context and queue, and lets clbvh build on them.

#include <CL/cl.h>

#include <clbvh/clbvh.hpp>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

void check(cl_int status, const char* call) {
    if (status != CL_SUCCESS) {
        throw std::runtime_error(std::string(call) + " failed with OpenCL error " + std::to_string(status));
    }
}

// The context and queue of a program that uses OpenCL for other things too.
class OwnOpenCl {
public:
    explicit OwnOpenCl(cl_device_id device) {
        cl_int status = CL_SUCCESS;
        context_ = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &status);
        check(status, "clCreateContext");
        queue_ = clCreateCommandQueue(context_, device, CL_QUEUE_PROFILING_ENABLE, &status);
        if (status != CL_SUCCESS) {
            clReleaseContext(context_);
            check(status, "clCreateCommandQueue");
        }
    }
    OwnOpenCl(const OwnOpenCl&) = delete;
    OwnOpenCl& operator=(const OwnOpenCl&) = delete;
    ~OwnOpenCl() {
        clReleaseCommandQueue(queue_);
        clReleaseContext(context_);
    }

    [[nodiscard]] cl_command_queue queue() const { return queue_; }

private:
    cl_context context_ = nullptr;
    cl_command_queue queue_ = nullptr;
};

// A square grid of `side` x `side` quads over a wavy surface.
clbvh::Mesh make_waves(std::uint32_t side) {
    clbvh::Mesh mesh;
    for (std::uint32_t row = 0; row <= side; ++row) {
        for (std::uint32_t column = 0; column <= side; ++column) {
            const auto x = static_cast<float>(column);
            const auto y = static_cast<float>(row);
            mesh.vertices.push_back({x, y, static_cast<float>((row * column) % 7)});
        }
    }
    for (std::uint32_t row = 0; row < side; ++row) {
        for (std::uint32_t column = 0; column < side; ++column) {
            const std::uint32_t corner = row * (side + 1) + column;
            mesh.triangles.push_back({corner, corner + 1, corner + side + 1});
            mesh.triangles.push_back({corner + 1, corner + side + 2, corner + side + 1});
        }
    }
    return mesh;
}

}  // namespace

int main() {
    try {
        const clbvh::DeviceInfo device = clbvh::pick_device();
        const OwnOpenCl own(static_cast<cl_device_id>(device.id));

        clbvh::Builder builder("plocpp", clbvh::Context::adopt(own.queue()));
        for (const std::uint32_t side : {16U, 64U, 128U}) {
            const clbvh::Mesh mesh = make_waves(side);
            clbvh::BuildStats stats;
            const clbvh::Bvh bvh = builder.build(mesh, &stats);
            const clbvh::ValidationReport report = clbvh::validate(bvh, mesh);
            if (!report) {
                throw std::runtime_error("broken tree: " + report.error);
            }
            std::cout << mesh.triangles.size() << " triangles on " << device.name << ": " << stats.build_ms << " ms, "
                      << stats.launches << " launches\n";
        }
        return builder.context().opencl_queue() == own.queue() ? 0 : 1;
    } catch (const std::exception& error) {
        std::cerr << "own_queue: " << error.what() << '\n';
        return 1;
    }
}
