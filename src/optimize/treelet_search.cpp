// The best tree over the leaves of a treelet, by dynamic programming. Karras, Aila 2013, "Fast Parallel Construction of
// High-Quality Bounding Volume Hierarchies", section 3.
#include "optimize/treelet_search.hpp"

#include <bit>

namespace clbvh::optimizer {

void TreeletSearch::run(std::span<const Box4> boxes) noexcept {
    all_ = (1u << boxes.size()) - 1;
    // Every part of a subset is a smaller number than the subset.
    for (std::uint32_t subset = 1; subset <= all_; ++subset) {
        const std::uint32_t rest = subset & (subset - 1);
        const Box4& box = boxes[static_cast<std::size_t>(std::countr_zero(subset))];
        if (rest == 0) {
            boxes_[subset] = box;
            costs_[subset] = 0.0f;
            continue;
        }
        boxes_[subset] = boxes_[rest];
        boxes_[subset].merge(box);
        // Of each two parts one has the first box; the other goes through the parts of the rest.
        std::uint32_t best_part = rest;
        float best = costs_[rest];
        for (std::uint32_t part = (rest - 1) & rest; part != 0; part = (part - 1) & rest) {
            const float cost = costs_[part] + costs_[subset ^ part];
            best_part = cost < best ? part : best_part;
            best = cost < best ? cost : best;
        }
        costs_[subset] = best + boxes_[subset].half_area();
        parts_[subset] = static_cast<std::uint8_t>(best_part);
    }
}

}  // namespace clbvh::optimizer
