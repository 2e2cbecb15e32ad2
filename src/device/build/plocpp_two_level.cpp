// PLOC++ Two-Level. Benthin, Drabinski, Tessari, Dittebrandt 2022, "PLOC++: Parallel Locally-Ordered Clustering for
// Bounding Volume Hierarchy Construction Revisited", section 4.5.

#include "device/build/device_algorithm.hpp"
#include "device/build/leaves.hpp"

namespace clbvh::device {
namespace {

// A round of splitting at most doubles the number of ranges.
std::uint32_t most_ranges(const BuildSettings& settings) {
    return 2 * settings.range_count;
}

// extra: begins [most + 1] and total, survivors [most * radius], survivor counts [most]
struct RangeViews {
    std::uint64_t begins_bytes, total_at, survivors_at, survivors_bytes, counts_at, end;
    explicit RangeViews(const BuildSettings& settings) {
        const std::uint64_t most = most_ranges(settings);
        begins_bytes = 4 * (most + 1);
        total_at = align_for_views(begins_bytes);
        survivors_at = total_at + align_for_views(4);
        survivors_bytes = 4 * most * settings.search_radius;
        counts_at = survivors_at + align_for_views(survivors_bytes);
        end = counts_at + 4 * most;
    }
};

std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t) {
    return RangeViews(settings).end;
}

ProgramSpec program(const BuildSettings& settings) {
    return {"plocpp_two_level.cl", settings.cluster_group_size,
            settings.search_defines() + " -D MAX_RANGES=" + std::to_string(most_ranges(settings))};
}

void cluster(const ClusterJob& job) {
    Launcher& launcher = job.launcher;
    const BuildBuffers& b = job.buffers;
    const std::uint32_t most = most_ranges(job.settings);
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(job.settings), name);
    };
    const RangeViews views(job.settings);
    const cl::Buffer begins = view_of(b.extra, 0, views.begins_bytes);
    const cl::Buffer total = view_of(b.extra, views.total_at, 4);
    const cl::Buffer survivors = view_of(b.extra, views.survivors_at, views.survivors_bytes);
    const cl::Buffer survivor_counts = view_of(b.extra, views.counts_at, 4 * std::uint64_t{most});
    // The codes share memory with the references, so the ranges are cut before the leaves are numbered.
    launcher.launch(kernel("extract_ranges"), 1, b.codes, b.leaf_count, job.settings.range_count, begins, total);
    launch_number_leaves(launcher, job.settings, b, job.leaf_count);
    launcher.launch(kernel("cluster_ranges"), most, begins, total, b.references_a, b.references_b, b.leaves, b.inner,
                    b.nodes, b.leaf_count, survivors, survivor_counts);
    launcher.count_bytes(
        round_bytes(job.leaf_count, job.leaf_count - 1, 0));  // at least: the rounds are the kernels' own
    launcher.launch(kernel("finish_ranges"), 1, survivors, survivor_counts, b.references_a, b.references_b, b.leaves,
                    b.inner, b.nodes, b.leaf_count, b.root_reference);
}

}  // namespace

const DeviceAlgorithm kPlocppTwoLevel{
    cluster, extra_bytes, {.chunks = true, .presets = false}, BoxOrder::morton, program};

}  // namespace clbvh::device
