// Benthin, Drabinski, Tessari, Dittebrandt 2022: PLOC++, sections 4.1 to 4.4 and 4.7.

#include <algorithm>

#include "device/device_algorithm.hpp"
#include "device/leaves.hpp"

namespace clbvh::device {
namespace {

std::uint64_t extra_bytes(const BuildSettings&, std::uint32_t) {
    return 0;
}

void cluster(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    launch_number_leaves(launcher, job.settings, b, job.leaf_count);
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel("plocpp.cl", name, job.settings.cluster_group_size,
                                         job.settings.search_defines());
    };
    const std::uint32_t chunk = job.settings.chunk_size(2 * job.settings.search_radius);
    const std::uint32_t groups = job.settings.groups_to_fill;
    std::uint32_t count = job.leaf_count;
    if (count > job.settings.single_group_threshold) {
        Kernel& search_merge = kernel("search_merge");
        Kernel& compact = kernel("compact");
        while (count > job.settings.single_group_threshold) {
            launcher.report(cluster_fraction(count, job.leaf_count));
            launcher.count_iteration(count);
            const Pieces pieces = cut_into_pieces(count, groups, chunk);
            const std::uint32_t chunks_per_group = pieces.length / chunk;
            launcher.launch(search_merge, pieces.count, b.references_a, count, chunks_per_group, b.leaves, b.inner,
                            b.nodes, b.leaf_count, b.references_b, b.counts);
            launcher.launch(compact, pieces.count, b.references_b, count, chunks_per_group, b.counts, b.references_a,
                            b.remaining);
            const std::uint32_t remaining = launcher.read_uint(b.remaining);
            // What stands after the merges is written, read and compacted.
            launcher.count_bytes(round_bytes(count, count - remaining, 4 + 4) + 4 * std::uint64_t{remaining});
            count = remaining;
        }
    }
    launcher.count_bytes(round_bytes(count, count - 1, 0));  // at least: the rounds are the kernel's own
    launcher.launch(kernel("finish"), 1, b.references_a, b.references_b, count, b.leaves, b.inner, b.nodes,
                    b.leaf_count, b.root_reference);
}

}  // namespace

const DeviceAlgorithm kPlocpp{cluster, extra_bytes};

}  // namespace clbvh::device
