// LBVH. Lauterbach, Garland, Sengupta, Luebke, Manocha 2009, "Fast BVH Construction on GPUs"; Karras 2012, "Maximizing
// Parallelism in the Construction of BVHs, Octrees, and k-d Trees"; Apetrei 2014, "Fast and Simple Agglomerative LBVH
// Construction".

#include <algorithm>

#include "device/build/device_algorithm.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPendingBytes = kernels::PENDING_BYTES;
constexpr std::uint32_t kMostPending = kernels::MOST_PENDING;
constexpr std::uint32_t kLeastPieceLength = 1024;
constexpr std::uint64_t kClimbBytes = kernels::CLIMB_BYTES;

std::uint32_t most_pieces(const BuildSettings& settings) {
    return std::min(2 * settings.groups_to_fill, kMostPieces);
}

/// What the group shape's work items tell each other, and where each stands.
struct GroupViews {
    GroupViews(const BuildSettings& settings, std::uint32_t leaf_count, ArrayLayout layout)
        : reached(layout.take_view(sizeof(cl_uint) * std::uint64_t{leaf_count})) {
        if (settings.climbs_in_steps()) climbs = layout.take_view(kClimbBytes * leaf_count);
        bytes = layout.bytes();
    }

    cl::Buffer reached;
    cl::Buffer climbs;  ///< where it waits for the end of a launch
    std::uint64_t bytes;
};

// Bytes for the subtrees that the lane shape's pieces leave to be joined, or for what the group shape needs.
std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t primitives) {
    return settings.lane() ? std::uint64_t{kPendingBytes} * kMostPending * most_pieces(settings)
                           : GroupViews(settings, primitives, ArrayLayout()).bytes;
}

ProgramSpec program(const BuildSettings& settings) {
    return {"lbvh.cl", settings.stream_group_size, ""};
}

void climb(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const std::size_t group_size = job.settings.stream_group_size;
    const std::size_t groups = (job.leaf_count + group_size - 1) / group_size;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    const GroupViews extra(job.settings, job.leaf_count, ArrayLayout(b.extra));
    launcher.launch(kernel("clear_nodes"), groups, b.leaf_count, extra.reached, b.nodes);
    if (!job.settings.climbs_in_steps()) {
        launcher.launch(kernel("climb_boxes"), groups, b.codes, b.primitive_ids, b.boxes, b.leaf_count, extra.reached,
                        b.nodes, b.root_reference);
        return;
    }
    launcher.launch(kernel("begin_climbs"), groups, b.leaf_count, extra.climbs, b.root_reference);
    for (std::uint32_t step = 0; step < std::min<std::uint32_t>(kernels::MOST_STEPS, job.leaf_count); ++step) {
        launcher.launch(kernel("climb_once"), groups, b.codes, b.primitive_ids, b.boxes, b.leaf_count, extra.reached,
                        b.nodes, b.root_reference, extra.climbs);
    }
}

void build_pieces(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    Session& session = launcher.session();
    const BuildBuffers& b = job.buffers;
    const Pieces pieces = cut_into_pieces(job.leaf_count, most_pieces(job.settings), kLeastPieceLength);
    const cl::Buffer pending = view_of(b.extra, 0, extra_bytes(job.settings, job.leaf_count));
    launcher.launch(session.kernel(program(job.settings), "build_pieces"), pieces.count, b.codes, b.primitive_ids,
                    b.boxes, b.leaf_count, pieces.length, b.nodes, pending, b.counts);
    launcher.launch(session.kernel(program(job.settings), "join_pieces"), 1, pending, b.counts, pieces.count,
                    b.leaf_count, b.nodes, b.root_reference);
}

void cluster(const ClusterJob& job) {
    // A code, an id and a box are read, a sibling pair is written.
    job.launcher.count_bytes((8 + 4 + 24 + 64) * std::uint64_t{job.leaf_count});
    if (job.settings.lane()) {
        build_pieces(job);
    } else {
        climb(job);
    }
}

}  // namespace

extern const DeviceAlgorithm kLbvh{.cluster = cluster,
                                   .extra_bytes = extra_bytes,
                                   .box_order = BoxOrder::input,
                                   .program = program,
                                   .hands_over = true};

}  // namespace clbvh::device
