// Meister, Bittner 2018: Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction.

#include <algorithm>

#include "device/device_algorithm.hpp"
#include "device/leaves.hpp"

namespace clbvh::device {
namespace {

// extra: neighbours (4 n), then the valid flags (n).
std::uint64_t neighbour_bytes(std::uint32_t primitives) {
    return align_for_views(4 * std::uint64_t{primitives});
}

std::uint64_t extra_bytes(const BuildSettings&, std::uint32_t primitives) {
    return neighbour_bytes(primitives) + primitives;
}

void cluster(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    launch_number_leaves(launcher, job.settings, b, job.leaf_count);
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel("ploc.cl", name, job.settings.cluster_group_size,
                                         job.settings.search_defines());
    };
    Kernel& search = kernel("search");
    Kernel& merge = kernel("merge");
    Kernel& count_valid = kernel("count_valid");
    Kernel& scan_counts = kernel("scan_counts");
    Kernel& compact = kernel("compact");
    const cl::Buffer neighbours = view_of(b.extra, 0, 4 * std::uint64_t{job.leaf_count});
    const cl::Buffer valid = view_of(b.extra, neighbour_bytes(job.leaf_count), job.leaf_count);
    const std::uint32_t chunk = job.settings.chunk_size(job.settings.search_radius);
    const std::uint32_t groups = job.settings.groups_to_fill;
    const cl::Buffer* references = &b.references_a;
    const cl::Buffer* compacted = &b.references_b;
    for (std::uint32_t count = job.leaf_count; count > 1;) {
        launcher.report(cluster_fraction(count, job.leaf_count));
        launcher.count_iteration(count);
        const Pieces pieces = cut_into_pieces(count, groups, chunk);
        launcher.launch(search, pieces.count, *references, count, pieces.length, b.leaves, b.inner, b.leaf_count,
                        neighbours);
        launcher.launch(merge, pieces.count, *references, count, pieces.length, neighbours, b.leaves, b.inner, b.nodes,
                        b.leaf_count, valid);
        launcher.launch(count_valid, pieces.count, valid, count, pieces.length, b.counts);
        launcher.launch(scan_counts, 1, b.counts, pieces.count, b.remaining);
        launcher.launch(compact, pieces.count, *references, valid, count, pieces.length, b.counts, *compacted);
        const std::uint32_t remaining = launcher.read_uint(b.remaining);
        // Neighbours are written and read, flags written and read twice; what is left is compacted; a merge gathers two
        // records.
        launcher.count_bytes(round_bytes(count, count - remaining, 4 + 4 + 3 + 4) + 4 * std::uint64_t{remaining} +
                             2 * 36 * std::uint64_t{count - remaining});
        count = remaining;
        std::swap(references, compacted);
    }
    launcher.session().queue().enqueueCopyBuffer(*references, b.root_reference, 0, 0, sizeof(cl_uint));
}

}  // namespace

const DeviceAlgorithm kPloc{cluster, extra_bytes};

}  // namespace clbvh::device
