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

/// The memory of this builder alone.
struct RangeViews {
    RangeViews(const BuildSettings& settings, ArrayLayout layout)
        : begins(layout.take_view(4 * (std::uint64_t{most_ranges(settings)} + 1))),
          total(layout.take_view(4)),
          survivors(layout.take_view(4 * std::uint64_t{most_ranges(settings)} * settings.configs.ploc.search_radius)),
          survivor_counts(layout.take_view(4 * std::uint64_t{most_ranges(settings)})),
          bytes(layout.bytes()) {}

    cl::Buffer begins, total, survivors, survivor_counts;
    std::uint64_t bytes;
};

std::uint64_t extra_bytes(const BuildSettings& settings, std::uint32_t) {
    return RangeViews(settings, ArrayLayout()).bytes;
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
    const RangeViews extra(job.settings, ArrayLayout(b.extra));
    // The codes share memory with the references, so the ranges are cut before the leaves are numbered.
    launcher.launch(kernel("extract_ranges"), 1, b.codes, b.leaf_count, job.settings.range_count, extra.begins,
                    extra.total);
    launch_number_leaves(launcher, job.settings, b, job.leaf_count);
    launcher.launch(kernel("cluster_ranges"), most, extra.begins, extra.total, b.references_a, b.references_b, b.leaves,
                    b.inner, b.nodes, b.leaf_count, extra.survivors, extra.survivor_counts);
    launcher.count_bytes(
        round_bytes(job.leaf_count, job.leaf_count - 1, 0));  // at least: the rounds are the kernels' own
    launcher.launch(kernel("finish_ranges"), 1, extra.survivors, extra.survivor_counts, b.references_a, b.references_b,
                    b.leaves, b.inner, b.nodes, b.leaf_count, b.root_reference);
}

}  // namespace

extern const DeviceAlgorithm kPlocppTwoLevel{.cluster = cluster,
                                             .extra_bytes = extra_bytes,
                                             .box_order = BoxOrder::morton,
                                             .program = program,
                                             .searches_chunks = true};

}  // namespace clbvh::device
