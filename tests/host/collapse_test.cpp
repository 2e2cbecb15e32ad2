// Collapsing is optimal, and sees nothing of a tree but its shape: not its numbering, its depth or the threads at work.
#include "clbvh/host/collapse.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <set>

#include "clbvh/core/validate.hpp"
#include "clbvh/host/binned_sah.hpp"
#include "clbvh/host/median.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Trees of random shape over lists of ids, in which an id may stand several times.
class RandomTree {
public:
    RandomTree(const Mesh& mesh, std::vector<std::uint32_t> ids, std::uint32_t max_leaf_size, std::uint32_t seed)
        : mesh_(mesh), max_leaf_size_(max_leaf_size), random_(seed) {
        tree_.primitive_count = mesh.triangles.size();
        tree_.primitive_ids = std::move(ids);
        tree_.split_references =
            std::set(tree_.primitive_ids.begin(), tree_.primitive_ids.end()).size() < tree_.primitive_ids.size();
        tree_.nodes.resize(2);
        fill(0, 0, static_cast<std::uint32_t>(tree_.primitive_ids.size()));
    }
    [[nodiscard]] const Bvh& tree() const { return tree_; }

private:
    void fill(std::size_t slot, std::uint32_t begin, std::uint32_t end) {
        Aabb box;
        for (std::uint32_t i = begin; i < end; ++i)
            box = merge(box, triangle_bounds(mesh_, tree_.primitive_ids[i]));
        const bool is_leaf = end - begin <= max_leaf_size_ && (end - begin == 1 || random_() % 2 == 0);
        const auto left = static_cast<std::uint32_t>(tree_.nodes.size());
        tree_.nodes[slot] = {{box.lower.x, box.lower.y, box.lower.z},
                             is_leaf ? begin : left,
                             {box.upper.x, box.upper.y, box.upper.z},
                             is_leaf ? end - begin : 0};
        if (is_leaf) return drop_repetitions(tree_.nodes[slot]);
        tree_.nodes.resize(tree_.nodes.size() + 2);
        const auto split = static_cast<std::uint32_t>(begin + 1 + random_() % (end - begin - 1));
        fill(left, begin, split);
        fill(left + 1, split, end);
    }

    void drop_repetitions(Node& leaf) {
        const auto begin = tree_.primitive_ids.begin() + leaf.first;
        std::sort(begin, begin + leaf.count);
        leaf.count = static_cast<std::uint32_t>(std::unique(begin, begin + leaf.count) - begin);
    }

    const Mesh& mesh_;
    std::uint32_t max_leaf_size_;
    std::mt19937 random_;
    Bvh tree_;
};

std::vector<std::uint32_t> ids_up_to(std::size_t count) {
    std::vector<std::uint32_t> ids(count);
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

/// The same tree in another numbering, with misleading nodes in between.
Bvh renumbered(const Bvh& tree, std::uint32_t seed) {
    std::vector<std::uint32_t> pairs = ids_up_to(2 * tree.nodes.size());
    std::shuffle(pairs.begin() + 1, pairs.end(), std::mt19937(seed));
    Bvh result = tree;
    const Node astray{{-1e30f, 0, 0}, 0, {1e30f, 1, 1}, 0};
    result.nodes.assign(2 * pairs.size(), astray);
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        Node node = tree.nodes[i];
        if (!node.is_leaf() && i != 1) node.first = 2 * pairs[node.first / 2];
        result.nodes[2 * pairs[i / 2] + i % 2] = node;
    }
    return result;
}

/// A tree whose left children are all leaves, or all of whose right ones are.
Bvh make_chain(const Mesh& mesh, bool leaves_left) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    Bvh tree;
    tree.primitive_count = count;
    tree.primitive_ids = ids_up_to(count);
    tree.nodes.resize(2 * count);
    const auto slot_of = [&](std::uint32_t i) { return i == 0 ? 0 : 2 * i + (leaves_left ? 1 : 0); };
    const auto set = [&](std::uint32_t slot, const Aabb& box, std::uint32_t first, std::uint32_t leaf_size) {
        tree.nodes[slot] = {
            {box.lower.x, box.lower.y, box.lower.z}, first, {box.upper.x, box.upper.y, box.upper.z}, leaf_size};
    };
    Aabb box = triangle_bounds(mesh, count - 1);
    set(slot_of(count - 1), box, count - 1, 1);
    for (std::uint32_t i = count - 1; i-- > 0;) {
        set(2 * (i + 1) + (leaves_left ? 0 : 1), triangle_bounds(mesh, i), i, 1);
        box = merge(box, triangle_bounds(mesh, i));
        set(slot_of(i), box, 2 * (i + 1), 0);
    }
    return tree;
}

double area(const Node& node) {
    const double x = double{node.upper[0]} - double{node.lower[0]};
    const double y = double{node.upper[1]} - double{node.lower[1]};
    const double z = double{node.upper[2]} - double{node.lower[2]};
    return x * y + y * z + z * x;
}

std::set<std::uint32_t> ids_below(const Bvh& tree, const Node& node) {
    const auto ids = tree.primitive_ids.begin();
    if (node.is_leaf()) return {ids + node.first, ids + node.first + node.count};
    std::set<std::uint32_t> left = ids_below(tree, tree.nodes[node.first]);
    left.merge(ids_below(tree, tree.nodes[node.first + 1]));
    return left;
}

/// Costs of the subtree for each way to cut it.
std::vector<double> costs_of_all_cuts(const Bvh& tree, const Node& node, const CollapseConfig& config) {
    if (node.is_leaf()) return {double{config.primitive_cost} * node.count * area(node)};
    std::vector<double> costs;
    const std::size_t below = ids_below(tree, node).size();
    if (below <= config.max_leaf_size) {
        costs.push_back(double{config.primitive_cost} * static_cast<double>(below) * area(node));
    }
    for (const double left : costs_of_all_cuts(tree, tree.nodes[node.first], config)) {
        for (const double right : costs_of_all_cuts(tree, tree.nodes[node.first + 1], config))
            costs.push_back(double{config.inner_cost} * area(node) + left + right);
    }
    return costs;
}

SahCosts sah_costs(const CollapseConfig& config) {
    return {config.inner_cost, config.primitive_cost};
}

std::vector<std::uint32_t> leaf_sizes(const Bvh& tree) {
    std::vector<std::uint32_t> sizes;
    for (const Node& node : tree.nodes) {
        if (node.is_leaf()) sizes.push_back(node.count);
    }
    return sizes;
}

void expect_least_cost(const Mesh& mesh, const Bvh& tree, const CollapseConfig& config) {
    const Bvh result = collapse(tree, config);
    const std::vector<double> costs = costs_of_all_cuts(tree, tree.nodes[0], config);
    const double least = *std::min_element(costs.begin(), costs.end()) / area(tree.nodes[0]);
    CHECK(sah_cost(result, sah_costs(config)) == Approx(least).epsilon(1e-12));
    CHECK(validate(result, mesh).error == "");
    CHECK(result.primitive_count == tree.primitive_count);
    CHECK(result.split_references == tree.split_references);
}

std::vector<Aabb> boxes_of(const Mesh& mesh) {
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(triangle_bounds(mesh, i));
    return boxes;
}

}  // namespace

TEST_CASE("collapse finds the cheapest of all cuts") {
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
        const std::size_t count = 1 + seed % 9;
        const Mesh mesh = random_triangles(count, seed);
        const Bvh tree = RandomTree(mesh, ids_up_to(count), 1 + seed % 3, seed).tree();
        INFO("seed " << seed);
        for (const std::uint32_t size : {1u, 2u, 4u, 64u}) {
            expect_least_cost(mesh, tree, {size, 1.2f, 1.0f});
            expect_least_cost(mesh, tree, {size, 0.1f, 3.0f});
            expect_least_cost(mesh, tree, {size, 20.0f, 1.0f});
        }
    }
}

TEST_CASE("collapse finds the cheapest of all cuts where leaves share primitives") {
    std::size_t shorter = 0;
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
        const Mesh mesh = random_triangles(4, seed);
        std::vector<std::uint32_t> ids{0, 1, 2, 3};
        for (std::uint32_t i = 0; i < 5; ++i)
            ids.push_back((seed >> i) % 4);
        std::shuffle(ids.begin(), ids.end(), std::mt19937(seed));
        const Bvh tree = RandomTree(mesh, ids, 2, seed).tree();
        INFO("seed " << seed);
        for (const std::uint32_t size : {1u, 2u, 3u, 8u}) {
            expect_least_cost(mesh, tree, {size, 1.2f, 1.0f});
            const Bvh result = collapse(tree, {size, 1.2f, 1.0f});
            shorter += result.primitive_ids.size() < tree.primitive_ids.size() ? 1 : 0;
        }
    }
    CHECK(shorter > 300);
}

TEST_CASE("collapsed trees are valid, no dearer, and collapsed for good") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        for (const std::uint64_t count : {0u, 1u, 2u, 3u, 1000u, 20000u}) {
            const Mesh mesh = generate_scene(scene.name, count);
            const std::vector<Aabb> boxes = boxes_of(mesh);
            for (const Bvh& tree : {build_median(boxes, {1}), build_median(boxes, {4}), build_binned_sah(boxes)}) {
                for (const std::uint32_t size : {1u, 4u, 64u}) {
                    INFO(scene.name << ":" << count << ", leaves of up to " << size);
                    const CollapseConfig config{size, 1.2f, 1.0f};
                    const Bvh result = collapse(tree, config);
                    CHECK(validate(result, mesh).error == "");
                    CHECK(sah_cost(result) <= sah_cost(tree) * (1 + 1e-12));
                    CHECK(same_bytes(collapse(result, config), result));
                    const std::vector<std::uint32_t> old_sizes = leaf_sizes(tree);
                    const std::vector<std::uint32_t> sizes = leaf_sizes(result);
                    const std::uint32_t largest_old =
                        old_sizes.empty() ? 0 : *std::max_element(old_sizes.begin(), old_sizes.end());
                    for (const std::uint32_t leaf_size : sizes)
                        REQUIRE(leaf_size <= std::max(size, largest_old));
                    CHECK(sizes.size() <= old_sizes.size());
                }
            }
        }
    }
}

TEST_CASE("collapse sees neither the numbering nor unused nodes") {
    for (const std::size_t count : {1u, 2u, 3u, 100u, 30000u}) {
        const Mesh mesh = random_triangles(count);
        const Bvh tree = RandomTree(mesh, ids_up_to(count), 2, 7).tree();
        const Bvh expected = collapse(tree);
        CHECK(same_bytes(collapse(renumbered(tree, 1)), expected));
        CHECK(same_bytes(collapse(renumbered(tree, 2)), expected));
    }
}

TEST_CASE("collapse gives the same bytes on any number of threads") {
    const Mesh mesh = generate_scene("city", 200000);
    const std::vector<Aabb> boxes = boxes_of(mesh);
    const Bvh chain = make_chain(mesh, false);
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
    for (const Bvh& tree : {build_median(boxes, {1}), RandomTree(mesh, ids_up_to(200000), 3, 5).tree(), chain}) {
        const Bvh expected = tbb::task_arena(1).execute([&] { return collapse(tree); });
        for (const int threads : {2, 4, 7}) {
            tbb::task_arena arena(threads);
            CHECK(same_bytes(arena.execute([&] { return collapse(tree); }), expected));
            CHECK(same_bytes(arena.execute([&] { return collapse(tree); }), expected));
        }
        CHECK(validate(expected, mesh).error == "");
    }
}

TEST_CASE("collapse takes trees of any depth") {
    const Mesh mesh = generate_scene("line", 100000);
    const Mesh coincident = coincident_triangles(100000);
    for (const bool leaves_left : {false, true}) {
        const Bvh deep = collapse(make_chain(mesh, leaves_left));
        CHECK(validate(deep, mesh).error == "");
        CHECK(sah_cost(deep) <= sah_cost(make_chain(mesh, leaves_left)) * (1 + 1e-12));
        const ValidationReport report = validate(collapse(make_chain(coincident, leaves_left), {1}), coincident);
        CHECK(report.error == "");
        CHECK(report.depth == 99999);
    }
}

TEST_CASE("parts of one primitive become one leaf, and very many of them stay apart") {
    const Mesh mesh = random_triangles(1);
    for (const std::size_t count : {2u, 255u, 256u}) {
        const Bvh result = collapse(RandomTree(mesh, std::vector<std::uint32_t>(count, 0), 1, 3).tree(), {1});
        CHECK(result.primitive_ids == std::vector<std::uint32_t>{0});
        CHECK(result.nodes.size() == 2);
    }
    for (const std::size_t count : {257u, 5000u}) {
        const Bvh result = collapse(RandomTree(mesh, std::vector<std::uint32_t>(count, 0), 1, 3).tree(), {1});
        CHECK(result.primitive_ids.size() >= 2);
        CHECK(result.primitive_ids.size() < count);
        CHECK(validate(result, mesh).error == "");
    }
}

TEST_CASE("leaves larger than the limit stay whole") {
    const Mesh mesh = coincident_triangles(20);
    const Bvh tree = build_median(boxes_of(mesh), {32});
    CHECK(same_bytes(collapse(tree, {4}), tree));
}

TEST_CASE("collapse refuses a config out of range by name") {
    const auto expect_refused = [](const CollapseConfig& config, const std::string& message) {
        expect_error(ErrorCode::invalid_input, {message}, [&] { (void)collapse(Bvh{}, config); });
    };
    expect_refused({0}, "max_leaf_size is 0; it must be 1 to 64");
    expect_refused({65}, "max_leaf_size is 65; it must be 1 to 64");
    expect_refused({8, 0.0f}, "inner_cost is 0; it must be finite and above 0");
    expect_refused({8, 1.2f, -1.0f}, "primitive_cost is -1; it must be finite and above 0");
    CHECK(collapse(Bvh{}).empty());
}
