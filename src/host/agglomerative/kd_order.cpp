#include "host/agglomerative/kd_order.hpp"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

namespace clbvh::host {
namespace {

/// Within blocks of this size the order does not matter.
constexpr std::size_t kBlock = 4;
/// How much a spread of extents counts against one of doubled centroids: enough to part concentric boxes, no more.
constexpr float kExtentWeight = 0.25f;
/// Ranges from this size on are split by two tasks, which may go on in parallel.
constexpr std::size_t kParallelRange = 4096;

/// A centroid's or a box's extent's coordinate, by which a range is split.
struct Coordinate {
    std::size_t axis;
    bool is_extent;

    [[nodiscard]] float of(const Reference& box) const noexcept {
        return is_extent ? box.upper[axis] - box.lower[axis] : box.lower[axis] + box.upper[axis];
    }
};

Coordinate widest_coordinate(std::span<const Reference> boxes) noexcept {
    Box4 centroids, extents;
    for (const Reference& reference : boxes) {
        const Box4 box = Box4::of(reference);
        centroids.merge(box.doubled_centroid());
        extents.merge(box.upper - box.lower);
    }
    const Float4 centroid_spread = centroids.upper - centroids.lower;
    const Float4 extent_spread = (extents.upper - extents.lower) * Float4::filled(kExtentWeight);
    const std::array<float, 6> spread{centroid_spread.x(), centroid_spread.y(), centroid_spread.z(),
                                      extent_spread.x(),   extent_spread.y(),   extent_spread.z()};
    const auto widest = static_cast<std::size_t>(std::ranges::max_element(spread) - spread.begin());
    return {widest % 3, widest >= 3};
}

}  // namespace

void order_by_kd_tree(std::span<Reference> boxes) {
    if (boxes.size() <= kBlock) return;
    const Coordinate coordinate = widest_coordinate(boxes);
    // The largest power of two below the size: so the left part is a whole block.
    const std::size_t middle = std::bit_ceil(boxes.size()) / 2;
    std::nth_element(boxes.begin(), boxes.begin() + static_cast<std::ptrdiff_t>(middle), boxes.end(),
                     [coordinate](const Reference& a, const Reference& b) {
                         const float coordinate_a = coordinate.of(a);
                         const float coordinate_b = coordinate.of(b);
                         return coordinate_a != coordinate_b ? coordinate_a < coordinate_b : a.primitive < b.primitive;
                     });
    const auto left = boxes.first(middle);
    const auto right = boxes.subspan(middle);
    if (boxes.size() < kParallelRange) {
        order_by_kd_tree(left);
        order_by_kd_tree(right);
    } else {
        tbb::parallel_invoke([&] { order_by_kd_tree(left); }, [&] { order_by_kd_tree(right); });
    }
}

}  // namespace clbvh::host
