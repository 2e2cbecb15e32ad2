// Surface area heuristic. Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", equation 1.
#include "clbvh/metrics/sah.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/exact_areas.hpp"
#include "core/own_group.hpp"
#include "core/simd/prefetch.hpp"
#include "core/tree_walk.hpp"
#include "metrics/check_costs.hpp"
#include "metrics/node_cost.hpp"

namespace clbvh {
namespace {

/// Sums of area times cost over sibling pairs, from the root down: slots that no node uses may hold anything.
class PairSums {
public:
    PairSums(std::span<const Node> nodes, const SahCosts& costs, bool is_flat)
        : nodes_(nodes), costs_(costs), is_flat_(is_flat) {}

    /// Of the pairs below and with the root's children. The parts that threads take, and the order in which these are
    /// added, depend on the tree alone.
    [[nodiscard]] double of_tree() const {
        std::vector<std::uint32_t> pairs;
        open(nodes_[0].first, pairs);
        double sum = 0.0;
        std::size_t begin = 0;
        while (begin < pairs.size() && pairs.size() - begin < kParts) {
            check_count(begin);
            sum += visit(pairs[begin++], pairs);
        }
        const std::span<const std::uint32_t> roots = std::span(pairs).subspan(begin);
        std::vector<double> sums(roots.size());
        tbb::parallel_for(std::size_t{0}, roots.size(), [&](std::size_t i) { sums[i] = of_subtree(roots[i]); });
        for (const double part : sums)
            sum += part;
        return sum;
    }

private:
    static constexpr std::size_t kParts = 512;
    static constexpr std::size_t kBatch = 16;

    /// Pairs are taken some at a time, whose inner children are being fetched meanwhile.
    [[nodiscard]] double of_subtree(std::uint32_t root) const {
        std::vector<std::uint32_t> stack{root};
        double sum = 0.0;
        for (std::size_t visited = 0; !stack.empty(); check_count(visited)) {
            std::array<std::uint32_t, kBatch> batch;
            const std::size_t count = std::min(stack.size(), kBatch);
            std::copy(stack.end() - static_cast<std::ptrdiff_t>(count), stack.end(), batch.begin());
            stack.resize(stack.size() - count);
            visited += count;
            for (std::size_t i = 0; i < count; ++i)
                sum += visit(batch[i], stack);
        }
        return sum;
    }

    /// Returns what two siblings cost, and appends the children of those that have any.
    double visit(std::uint32_t first, std::vector<std::uint32_t>& pairs) const {
        const std::span<const Node> siblings = nodes_.subspan(first, 2);
        std::array<double, 2> areas{1.0, 1.0};
        if (!is_flat_) areas = exact_half_areas(Box4::of(siblings[0]), Box4::of(siblings[1]));
        for (const Node& node : siblings) {
            if (node.is_leaf()) continue;
            open(node.first, pairs);
        }
        return areas[0] * node_cost(siblings[0], costs_) + areas[1] * node_cost(siblings[1], costs_);
    }

    void open(std::uint32_t first, std::vector<std::uint32_t>& pairs) const {
        if (first % 2 != 0 || std::size_t{first} + 1 >= nodes_.size()) refuse();
        prefetch(&nodes_[first]);
        pairs.push_back(first);
    }

    /// Who meets more pairs than there are walks in a circle.
    void check_count(std::size_t visited_pairs) const {
        if (visited_pairs > nodes_.size() / 2) refuse();
    }

    /// Names the first offender of the whole tree, whichever thread has met one.
    [[noreturn]] void refuse() const {
        TreeWalk walk(nodes_);
        while (walk.next()) {
        }
        throw Error(ErrorCode::invalid_input, walk.fault() + "; these nodes are not a tree: see what validate() says");
    }

    std::span<const Node> nodes_;
    SahCosts costs_;
    bool is_flat_;
};

}  // namespace

double sah_cost(const Bvh& bvh, const SahCosts& costs) {
    check_costs(costs);
    if (bvh.empty()) return 0.0;
    const Node& root = bvh.nodes[0];
    const double own_cost = node_cost(root, costs);
    if (root.is_leaf()) return own_cost;
    const double root_area = exact_half_area(root);
    const bool is_flat = !(root_area > 0.0);
    const double sum = in_own_group([&] { return PairSums(bvh.nodes, costs, is_flat).of_tree(); });
    return own_cost + sum / (is_flat ? 1.0 : root_area);
}

}  // namespace clbvh
