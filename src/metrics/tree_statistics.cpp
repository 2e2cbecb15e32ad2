#include "clbvh/metrics/tree_statistics.hpp"

#include <algorithm>
#include <cstddef>

#include "clbvh/core/error.hpp"
#include "core/box_overlap.hpp"
#include "core/exact_areas.hpp"
#include "core/tree_walk.hpp"

namespace clbvh {
namespace {

/// exact_half_area() of the box that both nodes share; 0 where they are apart.
double shared_area(const Node& a, const Node& b) {
    const Aabb box_a = a.bounds(), box_b = b.bounds();
    return touch(box_a, box_b) ? exact_half_area(intersect(box_a, box_b)) : 0.0;
}

void count(std::vector<std::uint64_t>& histogram, std::size_t value) {
    if (histogram.size() <= value) histogram.resize(value + 1, 0);
    ++histogram[value];
}

}  // namespace

double TreeStatistics::mean_leaf_depth() const noexcept {
    double sum = 0.0;
    for (std::size_t depth = 0; depth < leaves_by_depth.size(); ++depth)
        sum += static_cast<double>(depth) * static_cast<double>(leaves_by_depth[depth]);
    return leaves > 0 ? sum / static_cast<double>(leaves) : 0.0;
}

TreeStatistics tree_statistics(const Bvh& bvh) {
    TreeStatistics statistics;
    double overlap = 0.0;
    TreeWalk walk(bvh);
    while (walk.next()) {
        ++statistics.nodes;
        const Node& node = bvh.nodes[walk.node()];
        if (node.is_leaf()) {
            ++statistics.leaves;
            statistics.references += node.count;
            count(statistics.leaves_by_depth, walk.depth());
            count(statistics.leaves_by_size, node.count);
        } else {
            overlap += shared_area(bvh.nodes[node.first], bvh.nodes[node.first + 1]);
        }
    }
    if (walk.failed())
        throw Error(ErrorCode::invalid_input, walk.fault() + "; these nodes are not a tree: see what validate() says");
    const double root_area = bvh.empty() ? 0.0 : exact_half_area(bvh.nodes[0]);
    statistics.sibling_overlap = root_area > 0.0 ? overlap / root_area : 0.0;
    return statistics;
}

}  // namespace clbvh
