// A tree that is built fast and then made better, all on one queue: it stays in device memory, and nothing waits in
// between.

#include <CL/cl.h>

#include <clbvh/clbvh.hpp>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr std::uint32_t kBoxes = 20000;

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

// Boxes in no order, of sizes that differ.
std::vector<clbvh::Aabb> scattered_boxes() {
    std::uint32_t state = 1;
    const auto random = [&] {
        state = state * 1664525u + 1013904223u;
        return static_cast<float>(state >> 8) * 0x1p-24f;
    };
    std::vector<clbvh::Aabb> boxes(kBoxes);
    for (clbvh::Aabb& box : boxes) {
        const float x = random(), y = random(), z = random(), size = 0.1f * random() * random();
        box = {{x, y, z}, {x + size, y + size * random(), z + size * random()}};
    }
    return boxes;
}

void run() {
    const clbvh::Context context = clbvh::Context::open();
    cl_command_queue queue = context.opencl_queue();
    clbvh::DeviceBuilder builder("lbvh", context);
    clbvh::DeviceOptimizer optimizer("treelet", context);

    Buffers buffers(context);
    const clbvh::DeviceBuildSizes sizes = builder.sizes(kBoxes);
    const clbvh::DeviceResult result{buffers.make(sizes.nodes), buffers.make(sizes.primitive_ids), {}};
    const clbvh::DeviceBvh tree = clbvh::DeviceBvh::of(result, kBoxes);
    const clbvh::DeviceSpan scratch = buffers.make(sizes.scratch);
    const clbvh::DeviceSpan optimizer_scratch = buffers.make(optimizer.scratch_bytes(tree.node_count));
    const std::vector<clbvh::Aabb> boxes = scattered_boxes();
    const clbvh::DeviceBoxes input{kBoxes, buffers.make(boxes.size() * sizeof(clbvh::Aabb))};
    check(clEnqueueWriteBuffer(queue, input.boxes.buffer, CL_TRUE, 0, boxes.size() * sizeof(clbvh::Aabb), boxes.data(),
                               0, nullptr, nullptr),
          "clEnqueueWriteBuffer");

    const auto cost = [&] {
        clbvh::Bvh bvh;
        bvh.primitive_count = kBoxes;
        bvh.nodes.resize(tree.node_count);
        check(clEnqueueReadBuffer(queue, result.nodes.buffer, CL_TRUE, 0, bvh.nodes.size() * sizeof(clbvh::Node),
                                  bvh.nodes.data(), 0, nullptr, nullptr),
              "clEnqueueReadBuffer");
        return clbvh::sah_cost(bvh);
    };
    builder.enqueue(queue, input, scratch, result);
    std::cout << "SAH cost " << cost() << " as built";
    // Rays would go to the queue behind this; only the printing waits.
    optimizer.enqueue(queue, tree, optimizer_scratch);
    std::cout << ", " << cost() << " optimized\n";
}

}  // namespace

int main() {
    try {
        run();
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "optimize_on_queue: " << error.what() << '\n';
        return 1;
    }
}
