// H-PLOC. Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler 2024, "H-PLOC: Hierarchical Parallel Locally-Ordered
// Clustering for Bounding Volume Hierarchy Construction".

#include <algorithm>

#include "device/build/device_algorithm.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPlaces = 32;        // PLACES of hploc_reduce.clh and hploc_group.clh
constexpr std::uint64_t kClusterBytes = 32;  // Cluster of hploc_reduce.clh
constexpr std::uint32_t kMostLists = 194;    // MOST_LISTS of hploc_lane.clh
constexpr std::uint32_t kLeastPieceLength = 1024;
// Pieces differ in work, and few are left incomplete where they end: more than fill the device even that out.
constexpr std::uint32_t kPiecesPerGroup = 4;

// What the lane shape's work items leave for the last one: stacks of clusters, and where their lists begin.
struct LaneScratch {
    std::uint64_t stacks;        // bytes of all stacks, that of the last work item included
    std::uint64_t pending;       // bytes
    std::uint32_t stack_stride;  // clusters a stack
};

std::uint32_t most_pieces(const BuildSettings& settings) {
    return std::min(kPiecesPerGroup * settings.groups_to_fill, BuildBuffers::kMostPieces);
}

Pieces pieces_of(const BuildSettings& settings, std::uint32_t leaf_count) {
    return cut_into_pieces(leaf_count, most_pieces(settings), kLeastPieceLength);
}

// Grows with the leaves.
LaneScratch lane_scratch(const BuildSettings& settings, std::uint32_t leaf_count) {
    const std::uint64_t pieces = std::min<std::uint64_t>(leaf_count / kLeastPieceLength + 1, most_pieces(settings));
    const std::uint32_t most_clusters = (kMostLists + 1) * settings.hploc.cluster_limit;
    const std::uint32_t longest_piece = pieces_of(settings, leaf_count).length * 3 / 2;
    const std::uint32_t stride = std::min(most_clusters, longest_piece) + kPlaces;
    const std::uint64_t lists = kMostLists + 2 * settings.hploc.cluster_limit;
    return {align_for_views(kClusterBytes * (stride * pieces + most_clusters + kPlaces)),
            sizeof(std::uint32_t) * lists * pieces, stride};
}

std::uint64_t group_scratch(std::uint64_t leaf_count) {
    return align_for_views(sizeof(std::uint32_t) * leaf_count) + kClusterBytes * leaf_count;
}

std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t primitives) {
    if (!settings.lane()) {
        return group_scratch(primitives);
    }
    const LaneScratch scratch = lane_scratch(settings, primitives);
    return scratch.stacks + scratch.pending;
}

ProgramSpec program(const BuildSettings& settings) {
    return {"hploc.cl", settings.lane() ? 1 : kPlaces,
            settings.hploc_defines() + (settings.packed_keys() ? "" : " -D EQUAL_CODES=1")};
}

void cluster_in_lanes(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const Pieces pieces = pieces_of(job.settings, job.leaf_count);
    const LaneScratch scratch = lane_scratch(job.settings, job.leaf_count);
    const cl::Buffer stacks = view_of(b.extra, 0, scratch.stacks);
    const cl::Buffer pending = view_of(b.extra, scratch.stacks, scratch.pending);
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    launcher.launch(kernel("build_pieces"), pieces.count, b.codes, b.primitive_ids, b.boxes, b.leaf_count,
                    pieces.length, b.nodes, stacks, scratch.stack_stride, pending);
    launcher.launch(kernel("join_pieces"), 1, b.codes, b.leaf_count, pieces.count, pieces.length, b.nodes, stacks,
                    scratch.stack_stride, pending, b.root_reference);
}

void cluster_in_groups(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const std::uint64_t reached_bytes = sizeof(std::uint32_t) * std::uint64_t{job.leaf_count};
    const cl::Buffer reached = view_of(b.extra, 0, reached_bytes);
    const cl::Buffer inner = view_of(b.extra, align_for_views(reached_bytes), kClusterBytes * job.leaf_count);
    const std::size_t groups = (job.leaf_count + kPlaces - 1) / kPlaces;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    launcher.launch(kernel("prepare"), groups, b.leaf_count, reached, inner);
    launcher.launch(kernel("climb"), groups, b.codes, b.primitive_ids, b.boxes, b.leaf_count, reached, inner, b.nodes,
                    b.root_reference);
}

void cluster(const ClusterJob& job) {
    // A code, a primitive's number and its box are read, a sibling pair is written.
    job.launcher.count_bytes((8 + 4 + 24 + 64) * std::uint64_t{job.leaf_count});
    if (job.settings.lane()) {
        cluster_in_lanes(job);
    } else {
        cluster_in_groups(job);
    }
}

}  // namespace

const DeviceAlgorithm kHploc{cluster, extra_bytes, {.chunks = false, .presets = true}, BoxOrder::input, program};

}  // namespace clbvh::device
