// Boxes that move: a tree in device memory is refitted for each frame, and built anew where its cost has risen by half.
// Only the cost, two floats, comes to the host.

#include <CL/cl.h>

#include <array>
#include <clbvh/clbvh.hpp>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr std::uint32_t kBoxes = 20000;
constexpr int kFrames = 12;
constexpr float kDearer = 1.5f;

void check(cl_int status, const char* call) {
    if (status != CL_SUCCESS) {
        throw std::runtime_error(std::string(call) + " failed with OpenCL error " + std::to_string(status));
    }
}

// Buffers of one context, released with it.
class Buffers {
public:
    explicit Buffers(const clbvh::Context& context) : context_(context) {}
    Buffers(const Buffers&) = delete;
    Buffers& operator=(const Buffers&) = delete;
    ~Buffers() {
        for (cl_mem buffer : buffers_)
            clReleaseMemObject(buffer);
    }

    clbvh::DeviceSpan make(std::size_t bytes) {
        cl_int status = CL_SUCCESS;
        cl_mem buffer = clCreateBuffer(context_.opencl_context(), CL_MEM_READ_WRITE, bytes, nullptr, &status);
        check(status, "clCreateBuffer");
        buffers_.push_back(buffer);
        return {buffer};
    }

private:
    clbvh::Context context_;
    std::vector<cl_mem> buffers_;
};

// Boxes on circles, each at a speed of its own, so that neighbours part.
std::vector<clbvh::Aabb> boxes_at(float time) {
    std::vector<clbvh::Aabb> boxes(kBoxes);
    for (std::uint32_t i = 0; i < kBoxes; ++i) {
        const float part = static_cast<float>(i) / kBoxes;
        const float angle = 400.0f * part + time * (1.0f + static_cast<float>(i * 7919 % 101) / 101.0f);
        const float x = part * std::cos(angle), y = part * std::sin(angle), z = 0.1f * part;
        boxes[i] = {{x, y, z}, {x + 0.005f, y + 0.005f, z + 0.005f}};
    }
    return boxes;
}

void run() {
    const clbvh::Context context = clbvh::Context::open();
    cl_command_queue queue = context.opencl_queue();
    clbvh::DeviceBuilder builder("hploc", context);
    clbvh::DeviceRefitter refitter(context);

    Buffers buffers(context);
    const clbvh::DeviceBuildSizes sizes = builder.sizes(kBoxes);
    const clbvh::DeviceResult result{buffers.make(sizes.nodes), buffers.make(sizes.primitive_ids), {}};
    const clbvh::DeviceSpan build_scratch = buffers.make(sizes.scratch);
    const clbvh::DeviceBvh tree = clbvh::DeviceBvh::of(result, kBoxes);
    const clbvh::DeviceRefitSizes refit_sizes = refitter.sizes(tree.node_count, kBoxes);
    const clbvh::DeviceBoxes input{kBoxes, buffers.make(kBoxes * sizeof(clbvh::Aabb))};
    const clbvh::DeviceSpan sah = buffers.make(2 * sizeof(float));
    const clbvh::DeviceRefit refit{input, buffers.make(refit_sizes.order), buffers.make(refit_sizes.scratch), sah};
    const auto build = [&] {
        builder.enqueue(queue, input, build_scratch, result);
        refitter.enqueue_order(queue, tree, refit.order);
    };

    float built_cost = 0.0f;  // of the last tree that was built
    for (int frame = 0; frame < kFrames; ++frame) {
        // Where boxes are the work of a kernel, it goes to the queue here.
        const std::vector<clbvh::Aabb> boxes = boxes_at(0.05f * static_cast<float>(frame));
        check(clEnqueueWriteBuffer(queue, input.boxes.buffer, CL_TRUE, 0, boxes.size() * sizeof(clbvh::Aabb),
                                   boxes.data(), 0, nullptr, nullptr),
              "clEnqueueWriteBuffer");
        if (built_cost == 0.0f) build();
        refitter.enqueue(queue, tree, refit);
        std::array<float, 2> costs{};
        check(clEnqueueReadBuffer(queue, sah.buffer, CL_TRUE, 0, sizeof costs, costs.data(), 0, nullptr, nullptr),
              "clEnqueueReadBuffer");
        if (built_cost == 0.0f) built_cost = costs[1];
        std::cout << "frame " << frame << ": SAH cost " << costs[1] << '\n';
        if (costs[1] > kDearer * built_cost) built_cost = 0.0f;
    }
}

}  // namespace

int main() {
    try {
        run();
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "refit_on_queue: " << error.what() << '\n';
        return 1;
    }
}
