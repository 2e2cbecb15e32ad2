// Reinsertion on devices, step by step: the host's candidates, places and gains; moves whose changes of area add up;
// and a pass that is taken back leaves nothing behind.
#include "device/tree/reinsert.hpp"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <functional>
#include <iterator>
#include <set>

#include "clbvh/core/validate.hpp"
#include "clbvh/device/device_optimizer.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "clbvh/optimize/refit.hpp"
#include "core/exact_areas.hpp"
#include "device/build/stage_bench.hpp"
#include "device/tree/reinsert_steps.hpp"
#include "optimize/reinsertion.hpp"
#include "support/builders.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::ReinsertPasses;

namespace {

double inner_area(const Bvh& tree) {
    Bvh copy = tree;
    return optimizer::EditTree(copy.nodes).inner_half_area();
}

Bvh with_nodes(const Bvh& tree, const std::vector<Node>& nodes) {
    Bvh other = tree;
    other.nodes = nodes;
    return other;
}

/// Leading bits of the difference between the areas of parent and node, 0 where the node may not move; of all slots.
std::vector<std::uint32_t> ranks_of(const optimizer::EditTree& tree) {
    std::vector<std::uint32_t> ranks(tree.slot_count(), 0);
    for (std::uint32_t slot = 2; slot < tree.slot_count(); ++slot) {
        const std::uint32_t parent = tree.parent(slot);
        if (parent == optimizer::EditTree::kUnused || parent == 0) continue;
        const float difference = tree.box(parent).half_area() - tree.box(slot).half_area();
        ranks[slot] = 1 + (std::bit_cast<std::uint32_t>(std::max(difference, 0.0f)) >> 20);
    }
    return ranks;
}

/// The highest ranks, so many that they are kPart of the nodes that may move; of the lowest of them evenly.
std::vector<std::uint32_t> expected_candidates(const std::vector<std::uint32_t>& ranks) {
    std::vector<std::uint32_t> movable;
    std::ranges::copy_if(ranks, std::back_inserter(movable), [](std::uint32_t rank) { return rank > 0; });
    std::ranges::sort(movable, std::greater<>());
    const auto wanted = static_cast<std::size_t>(kPart * static_cast<float>(movable.size()));
    const std::uint32_t lowest = movable[wanted - 1];
    const auto count = static_cast<std::size_t>(std::ranges::count(movable, lowest));
    const auto quota = wanted - static_cast<std::size_t>(
                                    std::ranges::count_if(movable, [&](std::uint32_t rank) { return rank > lowest; }));
    std::vector<std::uint32_t> chosen;
    std::size_t met = 0;
    for (std::uint32_t slot = 0; slot < ranks.size(); ++slot) {
        bool is_chosen = ranks[slot] > lowest;
        if (ranks[slot] == lowest) {
            is_chosen = (met + 1) * quota / count > met * quota / count;
            ++met;
        }
        if (is_chosen) chosen.push_back(slot);
    }
    return chosen;
}

std::vector<std::uint32_t> slots_of(const std::vector<Found>& found) {
    std::vector<std::uint32_t> slots;
    for (const Found& one : found)
        slots.push_back(one.from);
    return slots;
}

/// Trees of a few thousand nodes of several kinds.
std::vector<std::pair<Bvh, Mesh>> some_trees() {
    std::vector<std::pair<Bvh, Mesh>> trees;
    for (const char* const scene : {"soup", "city", "hair", "clustered", "terrain"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        trees.emplace_back(make_builder("lbvh").build(mesh), mesh);
    }
    const Mesh mesh = random_triangles(700);
    trees.emplace_back(chain_tree(mesh), mesh);
    // A tree built without regard to where its triangles are, so that nearly all of them want to move, and across.
    const Mesh elsewhere = random_triangles(3000, 2);
    trees.emplace_back(make_builder("lbvh").build(random_triangles(3000, 1)), elsewhere);
    refit(trees.back().first, elsewhere);
    return trees;
}

/// A tree whose inner nodes form a chain, with two triangles on the left of each: searches go down to the right, and
/// leave a place behind at each step.
Bvh comb_tree(const Mesh& mesh) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    Bvh tree;
    tree.primitive_count = count;
    tree.primitive_ids.resize(count);
    tree.nodes.resize(2 * std::size_t{count});
    std::uint32_t spine = 0, next = 2;
    const auto stand_leaves = [&](std::uint32_t below, std::uint32_t triangle) {
        tree.nodes[below].first = next;
        for (const std::uint32_t side : {0u, 1u}) {
            tree.nodes[next + side].first = triangle + side;
            tree.nodes[next + side].count = 1;
            tree.primitive_ids[triangle + side] = triangle + side;
        }
        next += 2;
    };
    for (std::uint32_t triangle = 0; triangle + 2 < count; triangle += 2) {
        const std::uint32_t pair = next;
        tree.nodes[spine].first = pair;
        next += 2;
        stand_leaves(pair, triangle);
        spine = pair + 1;
    }
    stand_leaves(spine, count - 2);
    refit(tree, mesh);
    return tree;
}

}  // namespace

TEST_CASE("reinsert on devices: candidates are those of the largest differences, places and gains the host's") {
    for (auto& [tree, mesh] : some_trees()) {
        Bvh copy = tree;
        const optimizer::EditTree edit(copy.nodes);
        const std::vector<std::uint32_t> ranks = ranks_of(edit);
        optimizer::ReinsertionSearch search(edit);
        for (const Shape shape : kBothShapes) {
            INFO(to_string(shape) << ", " << tree.nodes.size() << " nodes");
            Steps steps(tree, shape);
            CHECK(static_cast<double>(steps.area()) * exact_half_area(tree.nodes[0]) / 2147483648.0 ==
                  Approx(inner_area(tree)).epsilon(1e-5));
            steps.passes.choose();
            CHECK((slots_of(steps.found()) == expected_candidates(ranks)));
            steps.passes.search();
            std::size_t gains = 0;
            for (const Found& found : steps.found()) {
                const optimizer::Reinsertion expected = search.find(found.from);
                CHECK(found.gain == expected.gain);
                if (expected.gain > 0.0f) CHECK(found.to == expected.to);
                gains += found.gain > 0.0f ? 1 : 0;
            }
            CHECK(gains > 0);
        }
    }
}

TEST_CASE("reinsert on devices: a move alone gains what was found") {
    for (auto& [tree, mesh] : some_trees()) {
        for (const Shape shape : kBothShapes) {
            Steps steps(tree, shape);
            steps.passes.choose();
            steps.passes.search();
            // The first with a gain alone.
            std::vector<Found> all = steps.found();
            const auto first = std::ranges::find_if(all, [](const Found& found) { return found.gain > 0.0f; });
            REQUIRE(first != all.end());
            const Found chosen = *first;
            for (Found& found : all) {
                if (found.from != chosen.from) found.gain = 0.0f;
            }
            write(steps.passes.views().found, all);
            steps.passes.lock();
            steps.passes.move();
            steps.passes.refit(false);
            const Bvh better = with_nodes(tree, steps.nodes());
            CHECK(validate(better, mesh).error == "");
            CHECK((leaves_of(better) == leaves_of(tree)));
            CHECK(inner_area(tree) - inner_area(better) == Approx(double{chosen.gain}).margin(1e-6 * inner_area(tree)));
            const std::int64_t before = steps.area();
            steps.passes.end();
            CHECK(static_cast<double>(steps.area()) / static_cast<double>(before) ==
                  Approx(inner_area(better) / inner_area(tree)).epsilon(1e-6));
        }
    }
}

TEST_CASE("reinsert on devices: moves of one pass share no slot, keep the tree, and leave books in order") {
    for (auto& [tree, mesh] : some_trees()) {
        for (const Shape shape : kBothShapes) {
            Steps steps(tree, shape);
            for (int pass = 0; pass < 4; ++pass) {
                INFO(to_string(shape) << ", " << tree.nodes.size() << " nodes, pass " << pass);
                const std::vector<Node> before = steps.nodes();
                steps.move();
                std::set<std::uint32_t> slots;
                std::size_t written = 0;
                for (const Found& move : steps.moved()) {
                    // The pivot is the former parent now.
                    slots.insert({move.pivot, move.from ^ 1, move.to});
                    written += 3;
                }
                CHECK(slots.size() == written);
                CHECK((written > 0 || pass > 0));
                const Bvh better = with_nodes(tree, steps.nodes());
                CHECK(validate(better, mesh).error == "");
                CHECK((leaves_of(better) == leaves_of(tree)));
                steps.passes.end();
                steps.passes.undo();
                steps.passes.refit(true);
                // State kept from pass to pass equals what a new start would compute.
                const Bvh after = with_nodes(tree, steps.nodes());
                CHECK(inner_area(after) <= inner_area(with_nodes(tree, before)));
                const Steps fresh(after, shape);
                CHECK((steps.ranks() == fresh.ranks()));
                CHECK((steps.words(steps.passes.views().histogram) == fresh.words(fresh.passes.views().histogram)));
                for (const auto* buffer :
                     {&steps.passes.views().arrivals, &steps.passes.views().locks, &steps.passes.views().moving}) {
                    CHECK(std::ranges::count(steps.words(*buffer), 0u) ==
                          static_cast<std::ptrdiff_t>(steps.words(*buffer).size()));
                }
                CHECK(static_cast<double>(steps.area()) ==
                      Approx(static_cast<double>(fresh.area())).margin(2.0 * static_cast<double>(tree.nodes.size())));
            }
        }
    }
}

TEST_CASE("reinsert on devices: a pass that is taken back leaves the tree as it was") {
    for (auto& [tree, mesh] : some_trees()) {
        for (const Shape shape : kBothShapes) {
            INFO(to_string(shape) << ", " << tree.nodes.size() << " nodes");
            Steps steps(tree, shape);
            const std::vector<std::uint16_t> ranks = steps.ranks();
            steps.move();
            CHECK((steps.nodes() != tree.nodes));
            steps.set_control(kernels::IS_UNDONE, 1);
            steps.passes.undo();
            steps.passes.refit(true);
            CHECK((steps.nodes() == tree.nodes));
            CHECK((steps.ranks() == ranks));
        }
    }
}

TEST_CASE("reinsert on devices: a pass after which the areas would add up to more is taken back") {
    const std::int64_t much = std::int64_t{1} << 40;
    for (auto& [tree, mesh] : some_trees()) {
        for (const Shape shape : kBothShapes) {
            INFO(to_string(shape) << ", " << tree.nodes.size() << " nodes");
            Steps steps(tree, shape);
            const std::int64_t area = steps.area();
            steps.move();
            CHECK((steps.nodes() != tree.nodes));
            // The books alone say so: rises and doubts in turn.
            const cl::Buffer& changes = steps.passes.views().move_changes;
            std::vector<std::int64_t> books = read<std::int64_t>(changes, 2 * steps.passes.sizes().groups);
            books[0] += much;
            write(changes, books);
            steps.passes.end();
            CHECK(steps.control(kernels::IS_UNDONE) == 1);
            CHECK(steps.area() == area);
            steps.passes.undo();
            steps.passes.refit(true);
            CHECK((steps.nodes() == tree.nodes));
        }
    }
}

TEST_CASE("reinsert on devices: trees become about as good as on the host") {
    const Mesh mesh = generate_scene("city", 8000);
    const Bvh tree = make_builder("lbvh").build(mesh);
    BuildOptions options;
    options.optimizers = "reinsert";
    const double on_host = sah_cost(make_builder("lbvh", options).build(mesh));
    CHECK(on_host < 0.95 * sah_cost(tree));
    CHECK(sah_cost(DeviceOptimizer("reinsert", shared_context()).optimize(tree)) <= 1.02 * on_host);
}

TEST_CASE("reinsert on devices: searches that have more places to look at than there is room for end in gains") {
    const Mesh mesh = random_triangles(1000);
    const Bvh comb = comb_tree(mesh);
    REQUIRE(validate(comb, mesh).error == "");
    REQUIRE(validate(comb, mesh).depth > 400);
    std::vector<Bvh> better;
    for (const Shape shape : kBothShapes) {
        DeviceOptimizerOptions options;
        options.shape = shape;
        better.push_back(DeviceOptimizer("reinsert", shared_context(), options).optimize(comb));
        CHECK(validate(better.back(), mesh).error == "");
        CHECK((leaves_of(better.back()) == leaves_of(comb)));
        CHECK(sah_cost(better.back()) < 0.8 * sah_cost(comb));
    }
    CHECK(same_bytes(better[0], better[1]));
}
