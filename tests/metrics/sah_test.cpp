#include "clbvh/metrics/sah.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>
#include <limits>

#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/oracle/tree_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Node inner(std::array<float, 3> lower, std::array<float, 3> upper, std::uint32_t first) {
    return {{lower[0], lower[1], lower[2]}, first, {upper[0], upper[1], upper[2]}, 0};
}

Node leaf(std::array<float, 3> lower, std::array<float, 3> upper, std::uint32_t first, std::uint32_t count) {
    return {{lower[0], lower[1], lower[2]}, first, {upper[0], upper[1], upper[2]}, count};
}

/// A box of 2 x 1 x 1 (surface area 10) with two unit cubes (6 each), the right one of which is cut into two slabs of
/// 1/2 x 1 x 1 (4 each), the last with three primitives.
Bvh hand_made_tree() {
    Bvh bvh;
    bvh.nodes = {inner({0, 0, 0}, {2, 1, 1}, 2),     {},
                 leaf({0, 0, 0}, {1, 1, 1}, 0, 1),   inner({1, 0, 0}, {2, 1, 1}, 4),
                 leaf({1, 0, 0}, {1.5, 1, 1}, 1, 1), leaf({1.5, 0, 0}, {2, 1, 1}, 2, 3)};
    bvh.primitive_ids = {0, 1, 2, 3, 4};
    bvh.primitive_count = 5;
    return bvh;
}

/// The recursive definition: cost of a subtree relative to its own root's area, scaled by the probability of a hit.
long double recursive_cost(const Bvh& bvh, std::uint32_t index, const SahCosts& costs) {
    const auto area = [&](std::uint32_t node) {
        const Node& n = bvh.nodes[node];
        const long double x = static_cast<long double>(n.upper[0]) - n.lower[0];
        const long double y = static_cast<long double>(n.upper[1]) - n.lower[1];
        const long double z = static_cast<long double>(n.upper[2]) - n.lower[2];
        return 2 * (x * y + x * z + y * z);
    };
    const Node& node = bvh.nodes[index];
    if (node.is_leaf()) return static_cast<long double>(costs.primitive) * node.count;
    const long double left = recursive_cost(bvh, node.first, costs) * area(node.first);
    const long double right = recursive_cost(bvh, node.first + 1, costs) * area(node.first + 1);
    return costs.inner + (left + right) / area(index);
}

}  // namespace

TEST_CASE("SAH cost of trees made by hand") {
    CHECK(sah_cost({}) == 0.0);

    Bvh single;
    single.nodes = {leaf({0, 0, 0}, {1, 2, 3}, 0, 4), {}};
    CHECK(sah_cost(single) == 4.0);
    CHECK(sah_cost(single, {1.2, 2.5}) == 10.0);

    const Bvh bvh = hand_made_tree();
    // 1.2 (10 + 6) / 10 + (1 * 6 + 1 * 4 + 3 * 4) / 10
    CHECK(sah_cost(bvh) == Approx(1.92 + 2.2).epsilon(1e-12));
    CHECK(sah_cost(bvh, {1.0, 0.0}) == Approx(1.6).epsilon(1e-12));
    CHECK(sah_cost(bvh, {0.0, 1.0}) == Approx(2.2).epsilon(1e-12));
    CHECK(sah_cost(bvh, {2.0, 3.0}) == Approx(3.2 + 6.6).epsilon(1e-12));
    CHECK(sah_cost(bvh, {0.0, 0.0}) == 0.0);
}

TEST_CASE("a root of zero area counts every node as hit") {
    Bvh bvh = hand_made_tree();
    for (Node& node : bvh.nodes)
        node = {{}, node.first, {}, node.count};
    CHECK(sah_cost(bvh) == Approx(2 * 1.2 + 5 * 1.0).epsilon(1e-12));
}

TEST_CASE("SAH cost equals the recursive definition") {
    for (const std::size_t count : {2u, 3u, 10u, 1000u, 20000u}) {
        const MortonOrder order = morton_order(random_triangles(count), MortonCode::xyz);
        for (const Bvh& bvh : {ploc_tree(order, 8, Comparison::exact).bvh, lbvh_tree(order).bvh}) {
            for (const SahCosts& costs : {SahCosts{}, SahCosts{1.0, 2.0}}) {
                const auto expected = static_cast<double>(recursive_cost(bvh, 0, costs));
                CHECK(sah_cost(bvh, costs) == Approx(expected).epsilon(1e-12));
            }
        }
    }
}

TEST_CASE("SAH cost does not depend on scale, numbering or the largest coordinates") {
    Bvh bvh = hand_made_tree();
    const double cost = sah_cost(bvh);
    std::swap(bvh.nodes[2], bvh.nodes[3]);
    CHECK(sah_cost(bvh) == Approx(cost).epsilon(1e-14));
    for (const float scale : {0x1p-60f, 0x1p59f}) {
        Bvh scaled = bvh;
        for (Node& node : scaled.nodes) {
            for (float& coordinate : node.lower)
                coordinate *= scale;
            for (float& coordinate : node.upper)
                coordinate *= scale;
        }
        CHECK(sah_cost(scaled) == sah_cost(bvh));
    }
}

TEST_CASE("SAH cost is the same to the bit on any number of threads") {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
    const Bvh bvh = lbvh_tree(morton_order(random_triangles(50000), MortonCode::xyz)).bvh;
    const double expected = tbb::task_arena(1).execute([&] { return sah_cost(bvh); });
    for (const int threads : {2, 4, 7})
        CHECK(tbb::task_arena(threads).execute([&] { return sah_cost(bvh); }) == expected);
}

TEST_CASE("unused slots do not count") {
    Bvh bvh = hand_made_tree();
    const double cost = sah_cost(bvh);
    bvh.nodes.push_back(leaf({0, 0, 0}, {9, 9, 9}, 0, 5));
    bvh.nodes.push_back(inner({0, 0, 0}, {9, 9, 9}, 0));
    CHECK(sah_cost(bvh) == cost);
}

TEST_CASE("costs that are negative or not finite are rejected") {
    const Bvh bvh = hand_made_tree();
    const auto expect_rejected = [&](const SahCosts& costs, const std::string& part) {
        expect_error(ErrorCode::invalid_input, {part, "finite and not negative"}, [&] { (void)sah_cost(bvh, costs); });
    };
    expect_rejected({-1.0, 1.0}, "an inner node is -1");
    expect_rejected({1.0, -0.5}, "a primitive is -0.5");
    expect_rejected({std::numeric_limits<double>::quiet_NaN(), 1.0}, "an inner node is nan");
    expect_rejected({1.0, std::numeric_limits<double>::infinity()}, "a primitive is inf");
}

TEST_CASE("SAH cost refuses nodes that form no tree") {
    const auto refused = [](const std::string& part, const auto& spoil) {
        Bvh bvh = hand_made_tree();
        spoil(bvh);
        expect_error(ErrorCode::invalid_input, {part}, [&] { (void)sah_cost(bvh); });
    };
    refused("node 0: its children 6 and 7 are out of range", [](Bvh& bvh) { bvh.nodes[0].first = 6; });
    refused("node 3: its children 6 and 7 are out of range", [](Bvh& bvh) { bvh.nodes[3].first = 6; });
    refused("node 3: its children 4294967294", [](Bvh& bvh) { bvh.nodes[3].first = 0xFFFFFFFEU; });
    refused("node 3: its children 3 and 4 start at an odd index", [](Bvh& bvh) { bvh.nodes[3].first = 3; });
    refused("node 3: its children 2 and 3 have another parent", [](Bvh& bvh) { bvh.nodes[3].first = 2; });
    refused("node 0: its children 0 and 1 have another parent", [](Bvh& bvh) { bvh.nodes[0].first = 0; });
}

TEST_CASE("SAH cost names the same node of a large tree on any number of threads") {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
    const Bvh sound = lbvh_tree(morton_order(random_triangles(50000), MortonCode::xyz)).bvh;
    Bvh out_of_range = sound, circle = sound;
    for (std::uint32_t i = 40000; i < 60000; i += 100) {
        if (sound.nodes[i].is_leaf()) continue;
        out_of_range.nodes[i].first += 100000;
        circle.nodes[i].first = i & ~1U;
    }
    for (const Bvh& bvh : {out_of_range, circle}) {
        const auto message = [&]() -> std::string {
            try {
                (void)sah_cost(bvh);
            } catch (const Error& error) {
                return error.what();
            }
            return {};
        };
        const std::string expected = tbb::task_arena(1).execute(message);
        CHECK(expected.starts_with("node "));
        for (const int threads : {2, 4, 7})
            CHECK(tbb::task_arena(threads).execute(message) == expected);
    }
}
