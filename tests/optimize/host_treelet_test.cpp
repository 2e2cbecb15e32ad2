// The tree over a treelet's leaves is the best there is: exhaustive search says the same.
#include "clbvh/optimize/treelet.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <map>

#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "optimize/edit_tree.hpp"
#include "optimize/treelet_search.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;
using optimizer::TreeletSearch;

namespace {

Box4 box4(const Aabb& box) {
    return {Float4::of(box.lower.x, box.lower.y, box.lower.z), Float4::of(box.upper.x, box.upper.y, box.upper.z)};
}

/// Puts the boxes one after the other beside every node of every tree over those before it: (2n - 3)!! trees.
class AllTrees {
public:
    explicit AllTrees(const std::vector<Aabb>& boxes) : boxes_(boxes) { extend({1u}, 1); }
    [[nodiscard]] double least_area() const { return least_; }
    [[nodiscard]] std::size_t count() const { return count_; }

private:
    /// A tree is the list of its nodes' subsets of boxes, leaves included.
    void extend(const std::vector<unsigned>& tree, std::size_t used) {
        if (used == boxes_.size()) {
            ++count_;
            double sum = 0.0;
            for (const unsigned subset : tree)
                sum += std::has_single_bit(subset) ? 0.0 : area(subset);
            least_ = std::min(least_, sum);
            return;
        }
        const unsigned added = 1u << used;
        for (const unsigned place : tree) {
            std::vector<unsigned> grown;
            for (const unsigned subset : tree)
                grown.push_back((subset & place) == place && subset != place ? subset | added : subset);
            grown.push_back(place | added);
            grown.push_back(added);
            extend(grown, used + 1);
        }
    }

    double area(unsigned subset) const {
        Aabb box;
        for (std::size_t i = 0; i < boxes_.size(); ++i) {
            if ((subset >> i & 1) != 0) box = merge(box, boxes_[i]);
        }
        return half_area(box);
    }

    const std::vector<Aabb>& boxes_;
    double least_ = std::numeric_limits<double>::infinity();
    std::size_t count_ = 0;
};

}  // namespace

TEST_CASE("treelet: dynamic programming finds what all 10395 trees over 7 leaves say") {
    TreeletSearch search;
    std::vector<std::vector<Aabb>> sets{random_boxes(7, 1), random_boxes(7, 2), grid_boxes(7, 3), random_boxes(5, 4),
                                        random_boxes(3, 5)};
    for (const BoxSet& set : hard_box_sets(7))
        sets.push_back(set.boxes);
    for (const std::vector<Aabb>& set : sets) {
        std::vector<Box4> boxes;
        for (const Aabb& box : set)
            boxes.push_back(box4(box));
        search.run(boxes);
        const AllTrees all(set);
        if (set.size() == 7) CHECK(all.count() == 10395);
        CHECK(double{search.least_area()} == Approx(all.least_area()).epsilon(1e-5));
        // The parts add up to it.
        double sum = 0.0;
        std::vector<std::uint32_t> stack{search.all()};
        while (!stack.empty()) {
            const std::uint32_t subset = stack.back();
            stack.pop_back();
            if (std::has_single_bit(subset)) continue;
            const std::uint32_t part = search.part_of(subset);
            REQUIRE(part != 0);
            REQUIRE(part != subset);
            REQUIRE((part & ~subset) == 0);
            Aabb box;
            for (std::size_t i = 0; i < set.size(); ++i) {
                if ((subset >> i & 1) != 0) box = merge(box, set[i]);
            }
            sum += half_area(box);
            stack.insert(stack.end(), {part, subset ^ part});
        }
        CHECK(sum == Approx(all.least_area()).epsilon(1e-5));
    }
}

TEST_CASE("treelet: a tree of seven leaves becomes the best there is") {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        const std::vector<Aabb> boxes = random_boxes(7, seed);
        Bvh tree = restructure_treelets(built_tree("lbvh", mesh_of_boxes(boxes)));
        const optimizer::EditTree edit(tree.nodes);
        CHECK(edit.inner_half_area() == Approx(AllTrees(boxes).least_area()).epsilon(1e-5));
    }
}

TEST_CASE("treelet: treelets of seven leaves find more than those of three, and fields out of range are named") {
    const Bvh tree = built_tree("lbvh", generate_scene("clustered", 10000));
    const auto cost_with = [&](std::uint32_t leaves) {
        TreeletConfig config;
        config.leaves = leaves;
        return sah_cost(restructure_treelets(tree, config));
    };
    CHECK(cost_with(3) < sah_cost(tree));
    CHECK(cost_with(7) < 0.95 * cost_with(3));
    for (const std::uint32_t leaves : {2u, 9u}) {
        TreeletConfig config;
        config.leaves = leaves;
        expect_error(ErrorCode::invalid_input, {"leaves"},
                     [&] { static_cast<void>(restructure_treelets(tree, config)); });
    }
}
