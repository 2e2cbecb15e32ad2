// Bottom-up refitting along a plan that was made before. Each sibling pair is one cache line that is read and written
// once: what inner children have become comes from a stack, not from their own pairs.
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/optimize/refit.hpp"
#include "core/exact_areas.hpp"
#include "core/memory_errors.hpp"
#include "core/merge_primitives.hpp"
#include "core/negative_zero.hpp"
#include "core/own_group.hpp"
#include "core/simd/box4.hpp"
#include "core/simd/prefetch.hpp"
#include "metrics/check_costs.hpp"
#include "optimize/refit_check.hpp"
#include "optimize/refit_plan.hpp"

namespace clbvh {
namespace {

using optimizer::RefitPlan;

/// An inner node with its new box.
struct Fitted {
    Box4 box;
    std::uint32_t pair;  ///< Of its children.
};

/// Sums of area times cost and of cost alone, and whether the tree was the one of the plan.
struct Sums {
    double before = 0.0;
    double after = 0.0;
    double costs = 0.0;
    bool fits_plan = true;

    void add(const Sums& other) noexcept {
        before += other.before;
        after += other.after;
        costs += other.costs;
        fits_plan = fits_plan && other.fits_plan;
    }
};

/// One call of refit().
template <typename Reader>
class Pass {
public:
    Pass(Bvh& tree, const Reader& primitives, const SahCosts& costs)
        : tree_(tree), primitives_(primitives), costs_(costs) {}

    /// Visits pairs from the last to the first. `stack` holds what is left when done.
    void visit_all(std::span<const RefitPlan::Visit> visits, std::vector<Fitted>& stack, Sums& sums) {
        for (std::size_t i = visits.size(); i > 0; --i) {
            if (i > kPairsAhead) prefetch(&tree_.nodes[std::size_t{2} * visits[i - 1 - kPairsAhead].pair()]);
            if (i > kPrimitivesAhead) prefetch_primitives(visits[i - 1 - kPrimitivesAhead]);
            stack.push_back(visit(visits[i - 1], stack, sums));
        }
    }

    Fitted visit(RefitPlan::Visit visit, std::vector<Fitted>& stack, Sums& sums) {
        Node* const nodes = &tree_.nodes[std::size_t{2} * visit.pair()];
        std::array<Box4, 2> boxes;
        for (std::uint32_t side = 0; side < 2; ++side)
            boxes[side] = visit.is_leaf(side) ? fit_leaf(nodes[side], sums) : take_inner(nodes[side], stack, sums);
        const std::array<double, 2> before = exact_half_areas(Box4::of(nodes[0]), Box4::of(nodes[1]));
        const std::array<double, 2> after = exact_half_areas(boxes[0], boxes[1]);
        for (std::uint32_t side = 0; side < 2; ++side)
            replace(nodes[side], boxes[side], before[side], after[side], sums);
        boxes[0].merge(boxes[1]);
        return {boxes[0], visit.pair()};
    }

    [[nodiscard]] const Node& root() const noexcept { return tree_.nodes[0]; }

    /// The root, which is no one's child. Returns its half areas before and after.
    std::array<double, 2> finish(const Box4& box, Sums& sums) {
        Node& root = tree_.nodes[0];
        const std::array<double, 2> areas = exact_half_areas(Box4::of(root), box);
        replace(root, box, areas[0], areas[1], sums);
        return areas;
    }

    Box4 take_inner(const Node& node, std::vector<Fitted>& stack, Sums& sums) const {
        const Fitted fitted = stack.back();
        stack.pop_back();
        if (node.count != 0 || node.first != 2 * fitted.pair) sums.fits_plan = false;
        return fitted.box;
    }

    Box4 fit_leaf(const Node& leaf, Sums& sums) const {
        Box4 box;
        if (!has_ids(leaf)) {
            sums.fits_plan = false;
            return box;
        }
        for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i)
            primitives_.merge_into(box, tree_.primitive_ids[i]);
        return without_negative_zeros(box);
    }

private:
    static constexpr std::size_t kPairsAhead = 24;
    static constexpr std::size_t kPrimitivesAhead = 8;

    [[nodiscard]] bool has_ids(const Node& leaf) const noexcept {
        const std::size_t ids = tree_.primitive_ids.size();
        return leaf.count > 0 && leaf.first < ids && leaf.count <= ids - leaf.first;
    }

    void prefetch_primitives(RefitPlan::Visit visit) const noexcept {
        const Node* const nodes = &tree_.nodes[std::size_t{2} * visit.pair()];
        for (std::uint32_t side = 0; side < 2; ++side) {
            if (visit.is_leaf(side) && nodes[side].first < tree_.primitive_ids.size())
                primitives_.prefetch_of(tree_.primitive_ids[nodes[side].first]);
        }
    }

    void replace(Node& node, const Box4& box, double area_before, double area_after, Sums& sums) const noexcept {
        const double cost = node.is_leaf() ? costs_.primitive * node.count : costs_.inner;
        sums.before += cost * area_before;
        sums.after += cost * area_after;
        sums.costs += cost;
        node = make_node(box, node.first, node.count);
    }

    Bvh& tree_;
    Reader primitives_;
    SahCosts costs_;
};

/// As sah_cost() sees it: where the root has no area, every node is hit.
double relative(double sum, double root_area, double costs) {
    return root_area > 0.0 ? sum / root_area : costs;
}

}  // namespace

struct CLBVH_NO_EXPORT Refitter::State {
    explicit State(const Bvh& tree) : node_count(tree.nodes.size()) {
        if (tree.empty() || tree.nodes[0].is_leaf()) return;
        plan.emplace(tree.nodes);
        results.resize(plan->subtree_count());
        chunk_sums.resize(plan->chunk_count());
    }

    template <typename Reader>
    RefitStats run(Pass<Reader> pass);
    template <typename Reader>
    void fit_chunks(Pass<Reader>& pass);
    template <typename Reader>
    Fitted fit_above(Pass<Reader>& pass, Sums& sums);

    std::size_t node_count;
    std::optional<RefitPlan> plan;  // nothing where there are no pairs
    std::vector<Fitted> results;    // of subtrees
    std::vector<Sums> chunk_sums;   // added in order, so that threads do not matter
    tbb::enumerable_thread_specific<std::vector<Fitted>> stacks;
};

template <typename Reader>
void Refitter::State::fit_chunks(Pass<Reader>& pass) {
    tbb::parallel_for(std::size_t{0}, plan->chunk_count(), [&](std::size_t i) {
        const RefitPlan::Chunk chunk = plan->chunk(i);
        std::vector<Fitted>& stack = stacks.local();
        stack.clear();
        chunk_sums[i] = {};
        pass.visit_all(chunk.visits, stack, chunk_sums[i]);
        std::ranges::reverse_copy(stack, results.begin() + static_cast<std::ptrdiff_t>(chunk.first_subtree));
    });
}

template <typename Reader>
Fitted Refitter::State::fit_above(Pass<Reader>& pass, Sums& sums) {
    std::vector<Fitted> stack;
    std::size_t subtrees = results.size();
    const std::span<const RefitPlan::Visit> above = plan->above();
    for (std::size_t i = above.size(); i > 0; --i) {
        const RefitPlan::Visit visit = above[i - 1];
        stack.push_back(visit.is_subtree() ? results[--subtrees] : pass.visit(visit, stack, sums));
    }
    return stack.back();
}

template <typename Reader>
RefitStats Refitter::State::run(Pass<Reader> pass) {
    const Node& root = pass.root();
    Sums sums;
    Box4 box;
    if (plan) {
        fit_chunks(pass);
        for (const Sums& of_chunk : chunk_sums)
            sums.add(of_chunk);
        std::vector<Fitted> last{fit_above(pass, sums)};
        box = pass.take_inner(root, last, sums);
    } else {
        box = pass.fit_leaf(root, sums);
    }
    const auto [area_before, area_after] = pass.finish(box, sums);
    if (!sums.fits_plan) {
        throw Error(ErrorCode::invalid_input,
                    "the tree's nodes are not those that the refitter was made for: make one for this tree, after "
                    "clbvh::refit() has mended its boxes");
    }
    return {relative(sums.before, area_before, sums.costs), relative(sums.after, area_after, sums.costs)};
}

Refitter::Refitter(const Bvh& tree)
    : state_(with_memory_errors("a refitter",
                                [&] { return in_own_group([&] { return std::make_unique<State>(tree); }); })) {}
Refitter::Refitter(Refitter&&) noexcept = default;
Refitter& Refitter::operator=(Refitter&&) noexcept = default;
Refitter::~Refitter() = default;

RefitStats Refitter::refit(Bvh& tree, const Primitives& primitives, const SahCosts& costs) {
    return with_memory_errors("refitting", [&] {
        check_costs(costs);
        if (tree.nodes.size() != state_->node_count) {
            throw Error(ErrorCode::invalid_input, "the tree has " + std::to_string(tree.nodes.size()) +
                                                      " nodes, but the refitter was made for one of " +
                                                      std::to_string(state_->node_count) + ": make one for this tree");
        }
        optimizer::check_same_primitives(tree, primitives);
        if (tree.empty()) return RefitStats{};
        return in_own_group([&] {
            return with_merging(primitives, [&](const auto& reader) { return state_->run(Pass(tree, reader, costs)); });
        });
    });
}

RefitStats refit(Bvh& tree, const Primitives& primitives, const SahCosts& costs) {
    return Refitter(tree).refit(tree, primitives, costs);
}

}  // namespace clbvh
