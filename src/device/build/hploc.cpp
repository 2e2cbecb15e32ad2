// H-PLOC. Benthin, Meister, Barczak, Mehalwal, Tsakok, Kensler 2024, "H-PLOC: Hierarchical Parallel Locally-Ordered
// Clustering for Bounding Volume Hierarchy Construction".

#include <algorithm>

#include "device/build/device_algorithm.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPlaces = kernels::PLACES;
constexpr std::uint64_t kClusterBytes = sizeof(float) * kernels::HPLOC_CLUSTER_FLOATS;
constexpr std::uint32_t kMostLists = kernels::MOST_LISTS;
constexpr std::uint32_t kLeastPieceLength = 1024;
// Pieces differ in work, and few are left incomplete where they end: more than fill the device even that out.
constexpr std::uint32_t kPiecesPerGroup = 4;

std::uint32_t most_pieces(const BuildSettings& settings) {
    return std::min(kPiecesPerGroup * settings.groups_to_fill, kMostPieces);
}

Pieces pieces_of(const BuildSettings& settings, std::uint32_t leaf_count) {
    return cut_into_pieces(leaf_count, most_pieces(settings), kLeastPieceLength);
}

/// Stacks of clusters that the lane shape's work items leave for the last one, and where their lists begin. Grow with
/// the leaves.
struct LaneViews {
    LaneViews(const BuildSettings& settings, std::uint32_t leaf_count, ArrayLayout layout) {
        const std::uint64_t pieces = std::min<std::uint64_t>(leaf_count / kLeastPieceLength + 1, most_pieces(settings));
        const std::uint32_t most_clusters = (kMostLists + 1) * settings.hploc.cluster_limit;
        const std::uint32_t longest_piece = pieces_of(settings, leaf_count).length * 3 / 2;
        stack_stride = std::min(most_clusters, longest_piece) + kPlaces;
        stacks = layout.take_view(kClusterBytes * (stack_stride * pieces + most_clusters + kPlaces));
        const std::uint64_t lists = kMostLists + 2 * settings.hploc.cluster_limit;
        pending = layout.take_view(sizeof(std::uint32_t) * lists * pieces);
        bytes = layout.bytes();
    }

    cl::Buffer stacks;  ///< of all pieces, and of the last work item behind them
    cl::Buffer pending;
    std::uint32_t stack_stride;  ///< clusters a stack
    std::uint64_t bytes;
};

struct GroupViews {
    GroupViews(std::uint64_t leaf_count, ArrayLayout layout)
        : reached(layout.take_view(sizeof(std::uint32_t) * leaf_count)),
          inner(layout.take_view(kClusterBytes * leaf_count)),
          bytes(layout.bytes()) {}

    cl::Buffer reached, inner;
    std::uint64_t bytes;
};

std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t primitives) {
    return settings.lane() ? LaneViews(settings, primitives, ArrayLayout()).bytes
                           : GroupViews(primitives, ArrayLayout()).bytes;
}

ProgramSpec program(const BuildSettings& settings) {
    return {"hploc.cl", settings.lane() ? 1 : kPlaces,
            settings.hploc_defines() + (settings.packed_keys() ? "" : " -D EQUAL_CODES=1")};
}

void cluster_in_lanes(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const Pieces pieces = pieces_of(job.settings, job.leaf_count);
    const LaneViews extra(job.settings, job.leaf_count, ArrayLayout(b.extra));
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    launcher.launch(kernel("build_pieces"), pieces.count, b.codes, b.primitive_ids, b.boxes, b.leaf_count,
                    pieces.length, b.nodes, extra.stacks, extra.stack_stride, extra.pending);
    launcher.launch(kernel("join_pieces"), 1, b.codes, b.leaf_count, pieces.count, pieces.length, b.nodes, extra.stacks,
                    extra.stack_stride, extra.pending, b.root_reference);
}

void cluster_in_groups(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const GroupViews extra(job.leaf_count, ArrayLayout(b.extra));
    const std::size_t groups = (job.leaf_count + kPlaces - 1) / kPlaces;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    launcher.launch(kernel("clear_clusters"), groups, b.leaf_count, extra.reached, extra.inner);
    launcher.launch(kernel("climb_clusters"), groups, b.codes, b.primitive_ids, b.boxes, b.leaf_count, extra.reached,
                    extra.inner, b.nodes, b.root_reference);
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

const DeviceAlgorithm kHploc{cluster, extra_bytes, BoxOrder::input, program};

}  // namespace clbvh::device
