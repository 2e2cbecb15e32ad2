// Object median: half of the primitives to each side of the median centroid along the longest axis.
#include "host/top_down/median.hpp"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>

#include "core/check_field.hpp"
#include "host/top_down/range_tree.hpp"

namespace clbvh::host {
namespace {

/// Ranges from this size on are split by two tasks, which may go on in parallel.
constexpr std::uint32_t kParallelSubtree = 2048;

class MedianBuilder {
public:
    MedianBuilder(HostBuild& build, const MedianConfig& config)
        : build_(build), config_(config), tree_(build.scratch, build.references.size()) {}

    void run() {
        const auto count = static_cast<std::uint32_t>(build_.references.size());
        build_.stages.begin("build", 0.05, 0.95, count);
        build_subtree(0, 0, count);
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree(tree_.slots(), build_.result);
    }

private:
    Extent build_subtree(std::uint32_t slot, std::uint32_t begin, std::uint32_t end) {
        const std::span<Reference> range = build_.references.subspan(begin, end - begin);
        Box4 box, centroids;
        for (const Reference& reference : range) {
            box.merge(Box4::of(reference));
            centroids.merge(Box4::of(reference).doubled_centroid());
        }
        if (range.size() <= config_.max_leaf_size) return tree_.set_leaf(slot, box, begin, range);

        const std::uint32_t middle = begin + (end - begin) / 2;
        partition(range, range.begin() + (middle - begin), longest_axis(centroids));
        const std::uint32_t left = RangeTree::left_child(middle);
        Extent left_extent, right_extent;
        if (range.size() < kParallelSubtree) {
            left_extent = build_subtree(left, begin, middle);
            right_extent = build_subtree(left + 1, middle, end);
        } else {
            tbb::parallel_invoke([&] { left_extent = build_task(left, begin, middle); },
                                 [&] { right_extent = build_task(left + 1, middle, end); });
        }
        return tree_.set_inner(slot, box, middle, left_extent, right_extent);
    }

    Extent build_task(std::uint32_t slot, std::uint32_t begin, std::uint32_t end) {
        const Extent extent = build_subtree(slot, begin, end);
        if (end - begin < kParallelSubtree) build_.stages.advance(end - begin);
        return extent;
    }

    static std::size_t longest_axis(const Box4& box) {
        const Float4 extents = box.upper - box.lower;
        const std::array<float, 3> extent{extents.x(), extents.y(), extents.z()};
        return static_cast<std::size_t>(std::ranges::max_element(extent) - extent.begin());
    }

    /// Ids decide between equal centroids, so that the halves do not depend on the order before.
    static void partition(std::span<Reference> range, std::span<Reference>::iterator middle, std::size_t axis) {
        std::nth_element(range.begin(), middle, range.end(), [axis](const Reference& a, const Reference& b) {
            const float a_centroid = a.lower[axis] + a.upper[axis];
            const float b_centroid = b.lower[axis] + b.upper[axis];
            return a_centroid != b_centroid ? a_centroid < b_centroid : a.primitive < b.primitive;
        });
    }

    HostBuild& build_;
    MedianConfig config_;
    RangeTree tree_;
};

}  // namespace

void build_median(HostBuild& build, const MedianConfig& config) {
    MedianBuilder(build, config).run();
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_median(const Primitives& primitives, const MedianConfig& config) {
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
    return host::build_over(primitives, [&](host::HostBuild& build) { host::build_median(build, config); });
}

}  // namespace clbvh
