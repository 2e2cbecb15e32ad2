// HLBVH. Pantaleoni, Luebke 2010, "HLBVH: Hierarchical LBVH Construction for Real-Time Ray Tracing of Dynamic
// Geometry"; Garanzha, Pantaleoni, McAllister 2011, "Simpler and Faster HLBVH with Work Queues".
//
// There clusters are the runs of equal leading bits of the Morton codes. Here they are what is below the nodes with the
// largest boxes of the finished LBVH: the cost of a tree is the area of its nodes, so that these are worth most. The
// top over them is binned SAH's, as it is there, and the host builds it, where the nodes lie.

#include <span>

#include "device/build/device_algorithm.hpp"
#include "host/top_down/cluster_top.hpp"

namespace clbvh::device {

extern const DeviceAlgorithm kLbvh;

namespace {

constexpr double kTopShare = 1.0 / 40;  // of the inner nodes

std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t primitives) {
    return kLbvh.extra_bytes(settings, primitives);
}

ProgramSpec program(const BuildSettings& settings) {
    return kLbvh.program(settings);
}

/// Builds the top of the tree in `nodes` anew; its root, which does not stand there yet, has its children in `pair`.
void build_top(std::span<Node> nodes, std::uint32_t pair, host::TopMemory& memory) {
    const Aabb box = merge(nodes[pair].bounds(), nodes[pair + 1].bounds());
    const Node root{{box.lower.x, box.lower.y, box.lower.z}, pair, {box.upper.x, box.upper.y, box.upper.z}, 0};
    memory.top.gather(nodes, 0, root, host::area_limit(nodes, kTopShare));
    if (!memory.top.inner.empty()) host::rebuild_top(nodes, memory.top, 0, host::build_by_bins, memory.workspace);
}

void cluster(const ClusterJob& job) {
    kLbvh.cluster(job);
    if (job.leaf_count < 3) return;
    job.launcher.report(0.8);
    const std::uint32_t root = job.launcher.read_uint(job.buffers.root_reference) - job.leaf_count;
    const std::size_t count = 2 * std::size_t{job.leaf_count};
    job.launcher.on_host(job.buffers.nodes, count * sizeof(Node), [&](void* nodes) {
        build_top({static_cast<Node*>(nodes), count}, 2 * root, *job.top_memory);
    });
}

}  // namespace

extern const DeviceAlgorithm kHlbvh{.cluster = cluster,
                                    .extra_bytes = extra_bytes,
                                    .box_order = BoxOrder::input,
                                    .program = program,
                                    .uses_host = true,
                                    .hands_over = true};

}  // namespace clbvh::device
