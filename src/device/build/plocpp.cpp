// PLOC++. Benthin, Drabinski, Tessari, Dittebrandt 2022, "PLOC++: Parallel Locally-Ordered Clustering for Bounding
// Volume Hierarchy Construction Revisited", sections 4.1 to 4.4 and 4.7.

#include <algorithm>
#include <array>

#include "device/build/device_algorithm.hpp"
#include "device/build/leaves.hpp"

namespace clbvh::device {
namespace {

std::uint64_t extra_bytes(const BuildSettings&, std::uint32_t) {
    return 0;
}

ProgramSpec program(const BuildSettings& settings) {
    return {"plocpp.cl", settings.cluster_group_size, settings.search_defines()};
}

/// Iterations with which any ordinary scene comes down to the threshold (docs/enqueue.md has the measurements). Where
/// they do not suffice, the last work group has more to do.
std::uint32_t enough_iterations(std::uint32_t clusters, std::uint32_t threshold) {
    std::uint32_t iterations = 0;
    for (std::uint64_t left = clusters; left > threshold; left = left * 7 / 8)
        ++iterations;
    return iterations;
}

/// The iterations of one build that have a launch each.
class Iterations {
public:
    explicit Iterations(const ClusterJob& job) : job_(job) {}

    /// Enqueues `iterations` more, over at most `clusters` clusters.
    void enqueue(std::uint32_t iterations, std::uint32_t clusters) {
        const BuildBuffers& b = job_.buffers;
        const std::uint32_t threshold = job_.settings.single_group_threshold;
        const std::uint32_t chunk = job_.settings.chunk_size(2 * job_.settings.configs.ploc.search_radius);
        const std::uint32_t groups = cut_into_pieces(clusters, job_.settings.groups_to_fill, chunk).count;
        Kernel& search_merge = kernel("search_merge");
        Kernel& compact = kernel("compact");
        for (const std::uint32_t end = enqueued_ + iterations; enqueued_ < end; ++enqueued_) {
            job_.launcher.launch(search_merge, groups, b.references_a, b.cluster_counts, enqueued_, threshold, b.leaves,
                                 b.inner, b.nodes, b.leaf_count, b.references_b, b.counts);
            job_.launcher.launch(compact, groups, b.references_b, b.cluster_counts, enqueued_, threshold, b.leaf_count,
                                 b.counts, b.references_a);
        }
    }

    /// Runs them down to the threshold, several at a time. Returns how many clusters are left.
    std::uint32_t run(std::uint32_t clusters) {
        std::array<std::uint32_t, BuildBuffers::kCountsKept> counts;
        const std::uint32_t threshold = job_.settings.single_group_threshold;
        while (clusters > threshold) {
            job_.launcher.report(cluster_fraction(clusters, job_.leaf_count));
            std::uint32_t iteration = enqueued_;
            enqueue(std::min(job_.settings.iterations_in_flight, enough_iterations(clusters, threshold)), clusters);
            job_.launcher.read_uints(job_.buffers.cluster_counts, counts);
            for (; iteration < enqueued_ && clusters > threshold; ++iteration) {
                const std::uint32_t remaining = counts[iteration % counts.size()];
                book(clusters, remaining);
                clusters = remaining;
            }
        }
        return clusters;
    }

    /// Enqueues the last work group, which goes on to the root.
    void enqueue_finish() {
        const BuildBuffers& b = job_.buffers;
        job_.launcher.launch(kernel("finish"), 1, b.references_a, b.references_b, b.cluster_counts, enqueued_, b.leaves,
                             b.inner, b.nodes, b.leaf_count, b.root_reference);
    }

private:
    Kernel& kernel(std::string_view name) { return job_.launcher.session().kernel(program(job_.settings), name); }

    void book(std::uint32_t clusters, std::uint32_t remaining) {
        job_.launcher.count_iteration(clusters);
        // The clusters left by the merges are written, read and compacted.
        job_.launcher.count_bytes(round_bytes(clusters, clusters - remaining, 4 + 4) + 4 * std::uint64_t{remaining});
    }

    const ClusterJob& job_;
    std::uint32_t enqueued_ = 0;
};

void cluster(const ClusterJob& job) {
    launch_number_leaves(job.launcher, job.settings, job.buffers, job.leaf_count);
    Iterations iterations(job);
    if (job.asynchronous) {
        iterations.enqueue(enough_iterations(job.leaf_count, job.settings.single_group_threshold), job.leaf_count);
    } else {
        const std::uint32_t left = iterations.run(job.leaf_count);
        job.launcher.count_bytes(round_bytes(left, left - 1, 0));  // at least: what follows is one kernel's own
    }
    iterations.enqueue_finish();
}

}  // namespace

extern const DeviceAlgorithm kPlocpp{.cluster = cluster,
                                     .extra_bytes = extra_bytes,
                                     .box_order = BoxOrder::morton,
                                     .program = program,
                                     .searches_chunks = true};

}  // namespace clbvh::device
