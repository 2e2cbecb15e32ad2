// PLOC. Meister, Bittner 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction".

#include <algorithm>
#include <array>

#include "device/build/device_algorithm.hpp"
#include "device/build/leaves.hpp"

namespace clbvh::device {
namespace {

/// The memory of ploc alone.
struct ExtraViews {
    ExtraViews(std::uint64_t primitives, ArrayLayout layout)
        : neighbours(layout.take_view(4 * primitives)), valid(layout.take_view(primitives)), bytes(layout.bytes()) {}

    cl::Buffer neighbours;  ///< uint [n]
    cl::Buffer valid;       ///< uchar [n]
    std::uint64_t bytes;
};

std::uint64_t extra_bytes(const BuildSettings&, std::uint32_t primitives) {
    return ExtraViews(primitives, ArrayLayout()).bytes;
}

ProgramSpec program(const BuildSettings& settings) {
    return {"ploc.cl", settings.cluster_group_size, settings.search_defines()};
}

/// The iterations of one build.
class Iterations {
public:
    explicit Iterations(const ClusterJob& job)
        : job_(job),
          search_(kernel("search")),
          merge_(kernel("merge")),
          count_valid_(kernel("count_valid")),
          scan_valid_(kernel("scan_valid")),
          compact_(kernel("compact")),
          extra_(job.leaf_count, ArrayLayout(job.buffers.extra)) {}

    /// Runs them down to the root, several at a time. There is one in any case: it leaves the root of a single leaf.
    void run() {
        std::array<std::uint32_t, BuildBuffers::kCountsKept> counts;
        std::uint32_t clusters = job_.leaf_count;
        do {
            job_.launcher.report(cluster_fraction(clusters, job_.leaf_count));
            std::uint32_t iteration = enqueued_;
            enqueue(clusters > 1 ? job_.settings.iterations_in_flight : 1, clusters);
            job_.launcher.read_uints(job_.buffers.cluster_counts, counts);
            for (; iteration < enqueued_ && clusters > 1; ++iteration) {
                const std::uint32_t remaining = counts[iteration % counts.size()];
                book(clusters, remaining);
                clusters = remaining;
            }
        } while (clusters > 1);
    }

private:
    /// Enqueues `iterations` more, over at most `clusters` clusters.
    void enqueue(std::uint32_t iterations, std::uint32_t clusters) {
        const std::uint32_t chunk = job_.settings.chunk_size(job_.settings.configs.ploc.search_radius);
        const std::uint32_t groups = cut_into_pieces(clusters, job_.settings.groups_to_fill, chunk).count;
        for (const std::uint32_t end = enqueued_ + iterations; enqueued_ < end; ++enqueued_)
            enqueue_one(groups);
    }

    void enqueue_one(std::uint32_t groups) {
        Launcher& launcher = job_.launcher;
        const BuildBuffers& b = job_.buffers;
        const cl::Buffer& references = enqueued_ % 2 == 0 ? b.references_a : b.references_b;
        const cl::Buffer& compacted = enqueued_ % 2 == 0 ? b.references_b : b.references_a;
        launcher.launch(search_, groups, references, b.cluster_counts, enqueued_, b.leaves, b.inner, b.leaf_count,
                        extra_.neighbours);
        launcher.launch(merge_, groups, references, b.cluster_counts, enqueued_, extra_.neighbours, b.leaves, b.inner,
                        b.nodes, b.leaf_count, extra_.valid);
        launcher.launch(count_valid_, groups, extra_.valid, b.cluster_counts, enqueued_, b.leaf_count, b.counts);
        launcher.launch(scan_valid_, 1, b.counts, groups, b.cluster_counts, enqueued_, b.leaf_count);
        launcher.launch(compact_, groups, references, extra_.valid, b.cluster_counts, enqueued_, b.leaf_count, b.counts,
                        compacted, b.root_reference);
    }

    Kernel& kernel(std::string_view name) { return job_.launcher.session().kernel(program(job_.settings), name); }

    void book(std::uint32_t clusters, std::uint32_t remaining) {
        const std::uint64_t merges = clusters - remaining;
        job_.launcher.count_iteration(clusters);
        // Neighbours are written and read, flags written and read twice; what is left is compacted; a merge gathers two
        // records.
        job_.launcher.count_bytes(round_bytes(clusters, merges, 4 + 4 + 3 + 4) + 4 * std::uint64_t{remaining} +
                                  72 * merges);
    }

    const ClusterJob& job_;
    Kernel &search_, &merge_, &count_valid_, &scan_valid_, &compact_;
    ExtraViews extra_;
    std::uint32_t enqueued_ = 0;
};

void cluster(const ClusterJob& job) {
    launch_number_leaves(job.launcher, job.settings, job.buffers, job.leaf_count);
    Iterations(job).run();
}

}  // namespace

extern const DeviceAlgorithm kPloc{.cluster = cluster,
                                   .extra_bytes = extra_bytes,
                                   .box_order = BoxOrder::morton,
                                   .program = program,
                                   .searches_chunks = true};

}  // namespace clbvh::device
