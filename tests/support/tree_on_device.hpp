#pragma once

#include "clbvh/device/device_optimizer.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"

namespace clbvh::test {

/// The nodes of a tree in device memory, and scratch for an optimiser.
struct TreeOnDevice {
    TreeOnDevice(const Bvh& tree, const DeviceOptimizer& optimizer)
        : count(static_cast<std::uint32_t>(tree.nodes.size())),
          nodes(context(), CL_MEM_READ_WRITE, tree.nodes.size() * sizeof(Node)),
          scratch(context(), CL_MEM_READ_WRITE, optimizer.scratch_bytes(count)) {
        queue().enqueueWriteBuffer(nodes, CL_TRUE, 0, tree.nodes.size() * sizeof(Node), tree.nodes.data());
    }
    static const cl::Context& context() { return shared_context().session().context(); }
    static const cl::CommandQueue& queue() { return shared_context().session().queue(); }
    [[nodiscard]] DeviceBvh target() const { return {{nodes()}, count, {}, 0, {}}; }
    [[nodiscard]] std::vector<Node> read() const {
        std::vector<Node> result(count);
        queue().enqueueReadBuffer(nodes, CL_TRUE, 0, count * sizeof(Node), result.data());
        return result;
    }

    std::uint32_t count;
    cl::Buffer nodes, scratch;
};

}  // namespace clbvh::test
