// H-PLOC. Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler 2024, "H-PLOC: Hierarchical Parallel Locally-Ordered
// Clustering for Bounding Volume Hierarchy Construction".

#include <algorithm>

#include "clbvh/core/error.hpp"
#include "device/build/device_algorithm.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPlaces = kernels::PLACES;
constexpr std::uint64_t kClusterBytes = sizeof(float) * kernels::HPLOC_CLUSTER_FLOATS;
constexpr std::uint64_t kClimbBytes = kernels::CLIMB_BYTES;
constexpr std::uint32_t kMostLists = kernels::MOST_LISTS;
constexpr std::uint32_t kMostPackedLeaves = 1u << kernels::PACKED_LEAF_BITS;
constexpr std::uint32_t kLeastPieceLength = kernels::LEAST_PIECE_LENGTH;
// Pieces differ in work, and few are left incomplete where they end: more than fill the device even that out.
constexpr std::uint32_t kPiecesPerGroup = 4;

std::uint32_t most_pieces(const BuildSettings& settings) {
    return std::min(kPiecesPerGroup * settings.groups_to_fill, kMostPieces);
}

Pieces pieces_of(const BuildSettings& settings, std::uint32_t leaf_count) {
    return cut_into_pieces(leaf_count, most_pieces(settings), kLeastPieceLength);
}

/// Leaves of several primitives, and what finding them takes; empty where each has one.
struct LeafViews {
    LeafViews(const BuildSettings& settings, std::uint32_t primitives, ArrayLayout& layout) {
        if (!settings.groups_primitives()) return;
        constexpr std::uint32_t word_bits = 64;
        pieces = cut_into_pieces(primitives, std::min(settings.groups_to_fill, kMostPieces), word_bits);
        codes = layout.take_view(sizeof(cl_ulong) * std::uint64_t{primitives});
        begins = layout.take_view(sizeof(cl_uint) * (std::uint64_t{primitives} + 1));
        bits = layout.take_view(sizeof(cl_ulong) * (std::uint64_t{primitives} / word_bits + 1));
        counts = layout.take_view(sizeof(cl_uint) * std::uint64_t{pieces.count});
    }

    Pieces pieces{};
    cl::Buffer codes, begins, bits, counts;
};

/// Stacks of clusters that the lane shape's work items leave for the last one, and where their lists begin. Grow with
/// the leaves.
struct LaneViews {
    LaneViews(const BuildSettings& settings, std::uint32_t leaf_count, ArrayLayout layout)
        : leaves(settings, leaf_count, layout) {
        const std::uint64_t pieces = std::min<std::uint64_t>(leaf_count / kLeastPieceLength + 1, most_pieces(settings));
        const std::uint32_t most_clusters = (kMostLists + 1) * settings.configs.hploc.cluster_limit;
        const std::uint32_t longest_piece = pieces_of(settings, leaf_count).length * 3 / 2;
        stack_stride = std::min(most_clusters, longest_piece) + kPlaces;
        stacks = layout.take_view(kClusterBytes * (stack_stride * pieces + most_clusters + kPlaces));
        const std::uint64_t lists = kMostLists + 2 * settings.configs.hploc.cluster_limit;
        pending = layout.take_view(sizeof(std::uint32_t) * lists * pieces);
        bytes = layout.bytes();
    }

    LeafViews leaves;
    cl::Buffer stacks;  ///< of all pieces, and of the last work item behind them
    cl::Buffer pending;
    std::uint32_t stack_stride;  ///< clusters a stack
    std::uint64_t bytes;
};

struct GroupViews {
    GroupViews(const BuildSettings& settings, std::uint32_t leaf_count, ArrayLayout layout)
        : leaves(settings, leaf_count, layout),
          reached(layout.take_view(sizeof(std::uint32_t) * std::uint64_t{leaf_count})),
          inner(layout.take_view(kClusterBytes * leaf_count)) {
        if (settings.climbs_in_steps()) climbs = layout.take_view(kClimbBytes * leaf_count);
        bytes = layout.bytes();
    }

    LeafViews leaves;
    cl::Buffer reached, inner;
    cl::Buffer climbs;  ///< where each work item stands, where it waits for the end of a launch
    std::uint64_t bytes;
};

std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t primitives) {
    if (settings.lane() && settings.groups_primitives() && primitives > kMostPackedLeaves) {
        throw Error(ErrorCode::unsupported, std::to_string(primitives) + " primitives are more than the " +
                                                std::to_string(kMostPackedLeaves) +
                                                " that hploc takes in the lane shape with a leaf_size above 1");
    }
    return settings.lane() ? LaneViews(settings, primitives, ArrayLayout()).bytes
                           : GroupViews(settings, primitives, ArrayLayout()).bytes;
}

std::string defines_of(const HplocConfig& config) {
    return " -D CLUSTER_LIMIT=" + std::to_string(config.cluster_limit) +
           " -D SMALL_RANGE=" + std::to_string(config.small_range) +
           " -D SMALL_LIMIT=" + std::to_string(config.small_limit) +
           " -D MERGE_PAIRS=" + (config.merge_pairs ? "1" : "0") +
           " -D SEARCH_RADIUS=" + std::to_string(config.search_radius) +
           " -D LEAF_SIZE=" + std::to_string(config.leaf_size);
}

ProgramSpec program(const BuildSettings& settings) {
    return {"hploc.cl", settings.lane() ? 1 : kPlaces,
            defines_of(settings.configs.hploc) + (settings.packed_keys() ? "" : " -D EQUAL_CODES=1")};
}

Kernel& kernel_of(const ClusterJob& job, std::string_view name) {
    return job.launcher.session().kernel(program(job.settings), name);
}

/// The leaves' codes, and where each leaf's primitives begin.
struct SortedLeaves {
    const cl::Buffer& codes;
    const cl::Buffer& begins;
};

SortedLeaves find_leaves(const ClusterJob& job, const LeafViews& views) {
    const BuildBuffers& b = job.buffers;
    if (!job.settings.groups_primitives()) return {b.codes, b.primitive_ids};  // begins that nobody reads
    Launcher& launcher = job.launcher;
    launcher.launch(kernel_of(job, "count_leaves"), views.pieces.count, b.codes, b.primitive_count, views.pieces.length,
                    views.bits, views.counts);
    launcher.launch(kernel_of(job, "write_leaves"), views.pieces.count, b.codes, b.primitive_count, views.pieces.length,
                    views.bits, views.counts, views.begins, views.codes, b.leaf_count);
    launcher.count_bytes((8 + 8) * std::uint64_t{job.leaf_count});
    return {views.codes, views.begins};
}

void cluster_in_lanes(const ClusterJob& job) {
    const BuildBuffers& b = job.buffers;
    const Pieces pieces = pieces_of(job.settings, job.leaf_count);
    const LaneViews extra(job.settings, job.leaf_count, ArrayLayout(b.extra));
    const SortedLeaves leaves = find_leaves(job, extra.leaves);
    job.launcher.launch(kernel_of(job, "build_pieces"), pieces.count, leaves.codes, b.primitive_ids, leaves.begins,
                        b.boxes, b.leaf_count, pieces.length, b.nodes, extra.stacks, extra.stack_stride, extra.pending);
    job.launcher.launch(kernel_of(job, "join_pieces"), 1, leaves.codes, b.leaf_count, pieces.count, pieces.length,
                        b.nodes, extra.stacks, extra.stack_stride, extra.pending, b.root_reference);
}

void cluster_in_groups(const ClusterJob& job) {
    const BuildBuffers& b = job.buffers;
    const GroupViews extra(job.settings, job.leaf_count, ArrayLayout(b.extra));
    const std::size_t groups = (job.leaf_count + kPlaces - 1) / kPlaces;
    const SortedLeaves leaves = find_leaves(job, extra.leaves);
    job.launcher.launch(kernel_of(job, "clear_clusters"), groups, b.leaf_count, extra.reached, extra.inner);
    if (!job.settings.climbs_in_steps()) {
        job.launcher.launch(kernel_of(job, "climb_clusters"), groups, leaves.codes, b.primitive_ids, leaves.begins,
                            b.boxes, b.leaf_count, extra.reached, extra.inner, b.nodes, b.root_reference);
        return;
    }
    job.launcher.launch(kernel_of(job, "begin_climbs"), groups, b.leaf_count, extra.climbs, b.root_reference);
    for (std::uint32_t step = 0; step < std::min<std::uint32_t>(kernels::MOST_STEPS, job.leaf_count); ++step) {
        job.launcher.launch(kernel_of(job, "climb_once"), groups, leaves.codes, b.primitive_ids, leaves.begins, b.boxes,
                            b.leaf_count, extra.reached, extra.inner, b.nodes, b.root_reference, extra.climbs);
    }
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

extern const DeviceAlgorithm kHploc{.cluster = cluster,
                                    .extra_bytes = extra_bytes,
                                    .box_order = BoxOrder::input,
                                    .program = program,
                                    .hands_over = true};

}  // namespace clbvh::device
