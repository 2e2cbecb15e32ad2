// Karras, Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", section 3.

#include <algorithm>
#include <bit>
#include <string>

#include "device/tree/device_optimizer_row.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPasses = 3;
constexpr std::uint32_t kLeastSize = 7;  // leaves below the roots of treelets, in the first pass
constexpr std::uint32_t kSubtreeBits = kernels::SUBTREE_BITS;
constexpr std::uint64_t kLevels = 33 - kSubtreeBits;
// Small groups wait little: a treelet has much that only a few work items can do.
constexpr std::size_t kGroupSize = 32;
// Work groups of a launch, as multiples of those that fill the device: subtrees differ in work.
constexpr std::uint32_t kLaneGroups = 4;
constexpr std::uint32_t kGroups = 16;
constexpr std::uint32_t kTreeletsOfLane = kernels::TREELETS;

ProgramSpec sizes_program(const OptimizeSettings& settings) {
    return {"treelet_sizes.cl", settings.stream_group_size, ""};
}

ProgramSpec search_program(const OptimizeSettings& settings) {
    return {"treelet.cl", std::min(settings.stream_group_size, kGroupSize),
            " -D TREELET_LEAVES=" + std::to_string(settings.treelet_leaves)};
}

std::vector<ProgramSpec> programs(const OptimizeSettings& settings) {
    return {parents_program(settings.stream_group_size), sizes_program(settings), search_program(settings)};
}

// The arrays of restructure() in treelet_lane.clh, which are vectors of 16 words: nodes, pairs, candidates, boxes of
// subsets of the first three leaves and of the others, costs and parts of subsets, walks.
std::uint64_t lane_local_bytes(const OptimizeSettings& settings) {
    const std::uint64_t subsets = std::uint64_t{1} << settings.treelet_leaves;
    return 64 * (64 + 8 + settings.treelet_leaves + 6 * 8 + 6 * (subsets / 8) + 2 * subsets + 2);
}

/// The arrays of one tree: kernels/tree/treelet_sizes.cl says what each is.
struct TreeletViews {
    TreeletViews(std::uint32_t node_count, ArrayLayout layout)
        : pairs(node_count / 2),
          parents(layout.take_view(4 * pairs)),
          sizes(layout.take_view(4 * pairs)),
          lists(layout.take_view(4 * (pairs / kLeastSize + (2 * pairs >> kSubtreeBits) + 1))),
          counts(layout.take_view(4 * kLevels)),
          bytes(layout.bytes()) {}

    std::uint64_t pairs;
    cl::Buffer parents, sizes, lists, counts;
    std::uint64_t bytes;
};

std::uint64_t scratch_bytes(const OptimizeSettings&, std::uint32_t node_count) {
    return TreeletViews(node_count, ArrayLayout()).bytes;
}

/// The passes over one tree.
class TreeletPasses {
public:
    explicit TreeletPasses(const OptimizeJob& job) : job_(job), v_(job.tree.node_count, ArrayLayout(job.scratch)) {}

    void run() {
        launch_parents(job_.launcher, job_.settings.stream_group_size, job_.tree, v_.parents);
        clear(v_.sizes, job_.tree.node_count / 2);
        launch_over_slots("count_leaves", v_.parents, v_.sizes);
        const std::uint32_t passes = job_.settings.passes != 0 ? job_.settings.passes : kPasses;
        std::uint64_t least_size = std::max(kLeastSize, job_.settings.treelet_leaves);
        for (std::uint32_t pass = 0; pass < passes && least_size <= v_.pairs; ++pass, least_size *= 2)
            restructure(static_cast<std::uint32_t>(least_size));
    }

private:
    template <class... Arguments>
    void launch_over_slots(const char* name, const Arguments&... arguments) {
        launch_on_tree(job_.launcher, job_.launcher.session().kernel(sizes_program(job_.settings), name),
                       slot_groups(job_.tree.node_count), job_.tree, arguments...);
    }

    void clear(const cl::Buffer& words, std::uint32_t count) {
        job_.launcher.launch(job_.launcher.session().kernel(sizes_program(job_.settings), "clear_words"),
                             slot_groups(count), words, count);
    }

    void restructure(std::uint32_t least_size) {
        clear(v_.counts, std::uint32_t{kLevels});
        launch_over_slots("list_subtrees", v_.sizes, least_size, v_.lists, v_.counts);
        const auto last_level = static_cast<std::uint32_t>(std::bit_width(v_.pairs >> kSubtreeBits));
        for (std::uint32_t level = 0; level <= last_level; ++level) {
            const std::uint64_t level_size = level == 0 ? 1 : std::uint64_t{1} << (kSubtreeBits + level - 1);
            const std::uint64_t most = v_.pairs / std::max<std::uint64_t>(least_size, level_size);
            launch_on_tree(job_.launcher, job_.launcher.session().kernel(search_program(job_.settings), "restructure"),
                           groups_for(most), job_.tree, v_.sizes, v_.parents, least_size, v_.lists, v_.counts, level);
        }
    }

    /// Groups for up to so many subtrees.
    [[nodiscard]] std::size_t groups_for(std::uint64_t subtrees) const {
        const std::uint64_t fill = job_.settings.groups_to_fill;
        if (!job_.settings.lane()) return std::clamp<std::uint64_t>(subtrees, 1, kGroups * fill);
        return std::clamp<std::uint64_t>(subtrees / kTreeletsOfLane, 1, kLaneGroups * fill);
    }

    const OptimizeJob& job_;
    TreeletViews v_;
};

void launch(const OptimizeJob& job) {
    TreeletPasses(job).run();
}

}  // namespace

const DeviceOptimizerRow kTreelet{programs, lane_local_bytes, scratch_bytes, launch};

}  // namespace clbvh::device
