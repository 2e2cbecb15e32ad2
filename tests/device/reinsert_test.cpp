// Reinsertion on devices, step by step: the host's candidates, places and gains; moves whose changes of area add up;
// and a pass that is taken back leaves nothing behind.
#include "device/reinsert.hpp"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <functional>
#include <iterator>
#include <set>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/optimize/refit.hpp"
#include "core/exact_areas.hpp"
#include "device/stage_bench.hpp"
#include "optimize/reinsertion.hpp"
#include "support/builders.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::ReinsertPasses;

namespace {

// Of all nodes, how many are candidates of the first pass: more than passes begin with, since the trees are small.
constexpr float kPart = 0.0625f;

struct Found {
    std::uint32_t from, to, pivot;
    float gain;
};

device::OptimizeSettings optimize_settings(Shape shape) {
    const device::BuildSettings build = settings_of(options_of(shape));
    device::OptimizeSettings settings;
    settings.shape = shape;
    settings.stream_group_size = build.stream_group_size;
    settings.groups_to_fill = build.groups_to_fill;
    return settings;
}

/// A tree on the device, and the steps of reinsertion on it.
class Steps {
public:
    Steps(const Bvh& tree, Shape shape)
        : settings_(optimize_settings(shape)),
          bench_(options_of(shape), 1),
          node_count_(static_cast<std::uint32_t>(tree.nodes.size())),
          nodes_(shared_context().session().context(), CL_MEM_READ_WRITE, tree.nodes.size() * sizeof(Node)),
          scratch_(shared_context().session().context(), CL_MEM_READ_WRITE,
                   device::kReinsert.scratch_bytes(settings_, node_count_)),
          job_{bench_.launcher, settings_, {nodes_, node_count_, {}}, {scratch_, 0}},
          passes(job_) {
        write(nodes_, tree.nodes);
        fill_bytes(scratch_, 0x5a);
        passes.begin();
        set_control(ReinsertPasses::kPart, std::bit_cast<std::uint32_t>(kPart));
    }

    [[nodiscard]] std::vector<Node> nodes() const { return read<Node>(nodes_, node_count_); }
    [[nodiscard]] std::vector<std::uint32_t> words(const cl::Buffer& buffer) const {
        return read<std::uint32_t>(buffer, buffer.getInfo<CL_MEM_SIZE>() / 4);
    }
    [[nodiscard]] std::vector<std::uint16_t> ranks() const {
        return read<std::uint16_t>(passes.views().ranks, node_count_);
    }
    [[nodiscard]] std::int64_t area() const { return read<std::int64_t>(passes.views().area, 1)[0]; }
    [[nodiscard]] std::uint32_t control(std::size_t word) const { return words(passes.views().control)[word]; }
    void set_control(std::size_t word, std::uint32_t value) {
        std::vector<std::uint32_t> control = words(passes.views().control);
        control[word] = value;
        write(passes.views().control, control);
    }
    [[nodiscard]] std::vector<Found> found() const {
        std::vector<Found> all = read<Found>(passes.views().found, passes.sizes().candidates);
        all.resize(control(ReinsertPasses::kCandidates));
        return all;
    }
    /// Those that were moved.
    [[nodiscard]] std::vector<Found> moved() const {
        const std::vector<std::uint32_t> state = words(passes.views().state);
        std::vector<Found> moves;
        const std::vector<Found> all = found();
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (state[i] == 1) moves.push_back(all[i]);
        }
        return moves;
    }
    void move() {
        passes.choose();
        passes.search();
        passes.lock();
        passes.move();
        passes.refit(false);
    }

private:
    device::OptimizeSettings settings_;
    StageBench bench_;
    std::uint32_t node_count_;
    cl::Buffer nodes_, scratch_;
    device::OptimizeJob job_;

public:
    ReinsertPasses passes;
};

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
    // A tree that knows nothing of where its triangles are, so that nearly all of them want to move, and across.
    const Mesh elsewhere = random_triangles(3000, 2);
    trees.emplace_back(make_builder("lbvh").build(random_triangles(3000, 1)), elsewhere);
    refit(trees.back().first, elsewhere);
    return trees;
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
                // What is kept from pass to pass is what a new beginning would find.
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
            steps.set_control(ReinsertPasses::kIsUndone, 1);
            steps.passes.undo();
            steps.passes.refit(true);
            CHECK((steps.nodes() == tree.nodes));
            CHECK((steps.ranks() == ranks));
        }
    }
}
