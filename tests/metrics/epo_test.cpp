#include "clbvh/metrics/epo.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/tree_statistics.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/oracle/epo_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Node leaf(const Aabb& box, std::uint32_t first, std::uint32_t count) {
    return {{box.lower.x, box.lower.y, box.lower.z}, first, {box.upper.x, box.upper.y, box.upper.z}, count};
}

Node inner(const Aabb& box, std::uint32_t first) {
    return leaf(box, first, 0);
}

/// Two right triangles of area 8 in the planes z = 0 and z = 1, and a tree of one leaf each whose boxes reach from
/// z = 0 to z = `top`.
struct TwoSheets {
    explicit TwoSheets(float top) {
        mesh = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, 0, 1}, {6, 0, 1}, {2, 4, 1}}, {{0, 1, 2}, {3, 4, 5}}};
        bvh.nodes = {inner({{0, 0, 0}, {6, 4, 1}}, 2),
                     {},
                     leaf({{0, 0, 0}, {4, 4, top}}, 0, 1),
                     leaf({{2, 0, 1 - top}, {6, 4, 1}}, 1, 1)};
        bvh.primitive_ids = {0, 1};
        bvh.primitive_count = 2;
    }

    Mesh mesh;
    Bvh bvh;
};

std::vector<Bvh> trees_over(const Mesh& mesh) {
    std::vector<Bvh> trees;
    for (const std::string_view id : device_builders())
        trees.push_back(built_tree(id, mesh, options_of(Shape::lane)));
    for (const std::string_view id : host_builders())
        trees.push_back(Builder(id).build(mesh));
    BuildOptions split;
    split.presplit_level = 8;
    split.max_leaf_size = 4;
    trees.push_back(Builder("median", split).build(mesh));
    return trees;
}

/// Equal triangles in a long row, with room between them.
Mesh apart(std::size_t count) {
    Mesh mesh = random_triangles(count);
    for (std::size_t i = 3; i < mesh.vertices.size(); ++i) {
        const Vec3& before = mesh.vertices[i - 3];
        mesh.vertices[i] = {before.x + 4.0f, before.y, before.z};
    }
    return mesh;
}

/// The tree, all boxes times `factor`.
Bvh scaled(Bvh bvh, float factor) {
    for (Node& node : bvh.nodes) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            node.lower[axis] *= factor;
            node.upper[axis] *= factor;
        }
    }
    return bvh;
}

/// The same tree, its pairs of siblings in another order.
Bvh renumbered(const Bvh& bvh) {
    Bvh other = bvh;
    const std::size_t last = bvh.nodes.size() / 2 - 1;
    for (std::size_t pair = 1; pair <= last; ++pair) {
        for (std::size_t child = 0; child < 2; ++child) {
            Node node = bvh.nodes[2 * pair + child];
            if (!node.is_leaf()) node.first = static_cast<std::uint32_t>(2 * (last + 1 - node.first / 2));
            other.nodes[2 * (last + 1 - pair) + child] = node;
        }
    }
    if (!bvh.nodes[0].is_leaf())
        other.nodes[0].first = static_cast<std::uint32_t>(2 * (last + 1 - bvh.nodes[0].first / 2));
    return other;
}

}  // namespace

TEST_CASE("EPO of trees made by hand") {
    CHECK(end_point_overlap({}, {}) == 0.0);
    const TwoSheets flat(0.0f);
    CHECK(end_point_overlap(flat.bvh, flat.mesh) == 0.0);
    // In each leaf's box lies what the other triangle has before x = 4, and beyond x = 2.
    const TwoSheets tall(1.0f);
    CHECK(end_point_overlap(tall.bvh, tall.mesh) == Approx((6.0 + 2.0) / 16.0).epsilon(1e-14));
    CHECK(end_point_overlap(tall.bvh, tall.mesh, {7.0, 3.0}) == Approx(3.0 * 8.0 / 16.0).epsilon(1e-14));

    // An inner node instead of the first leaf costs C_inner; the leaf around nothing below it counts nothing.
    TwoSheets deep(1.0f);
    deep.mesh.triangles.push_back({0, 0, 0});
    deep.bvh.primitive_ids.push_back(2);
    deep.bvh.nodes[2] = inner(deep.bvh.nodes[2].bounds(), 4);
    deep.bvh.nodes.insert(deep.bvh.nodes.end(),
                          {leaf({{0, 0, 0}, {4, 4, 0}}, 0, 1), leaf({{0, 0, 0}, {0, 0, 0}}, 2, 1)});
    CHECK(end_point_overlap(deep.bvh, deep.mesh) == Approx((1.2 * 6.0 + 2.0) / 16.0).epsilon(1e-14));
}

TEST_CASE("a split triangle belongs to every node above its leaves") {
    TwoSheets sheets(1.0f);
    sheets.bvh.primitive_ids = {0, 1, 0, 1};
    sheets.bvh.split_references = true;
    sheets.bvh.nodes[2].count = 2;
    CHECK(end_point_overlap(sheets.bvh, sheets.mesh) == Approx(2.0 / 16.0).epsilon(1e-14));
    sheets.bvh.nodes[3] = leaf(sheets.bvh.nodes[3].bounds(), 2, 2);
    CHECK(end_point_overlap(sheets.bvh, sheets.mesh) == 0.0);
}

TEST_CASE("EPO is equation 3, node by node, for the trees of all builders") {
    Mesh with_inactive = generate_scene("soup", 150, 3);
    deactivate_triangles(with_inactive, 1, 10);
    for (const Mesh& mesh : {generate_scene("city", 200), generate_scene("hair", 200), with_inactive,
                             coincident_triangles(20), random_triangles(1), random_triangles(2)}) {
        for (const Bvh& bvh : trees_over(mesh)) {
            for (const SahCosts& costs : {SahCosts{}, SahCosts{1.0, 0.0}, SahCosts{0.5, 3.0}}) {
                const double expected = epo_oracle(bvh, mesh, costs);
                REQUIRE(end_point_overlap(bvh, mesh, costs) == Approx(expected).epsilon(1e-9).margin(1e-12));
            }
        }
    }
}

TEST_CASE("trees whose boxes are apart have no overlap") {
    const Mesh mesh = apart(300);
    for (const char* id : {"median", "binned-sah", "sweep-sah", "locally-ordered"}) {
        const Bvh bvh = Builder(id).build(mesh);
        CHECK(end_point_overlap(bvh, mesh) == 0.0);
        CHECK(end_point_overlap_sampled(bvh, mesh, 5000).value == 0.0);
    }
}

TEST_CASE("a scene without area, and one without triangles, have no overlap") {
    Mesh mesh = random_triangles(50);
    for (Triangle& triangle : mesh.triangles)
        triangle[2] = triangle[1];
    const Bvh bvh = Builder("median").build(mesh);
    CHECK(end_point_overlap(bvh, mesh) == 0.0);
    const Estimate estimate = end_point_overlap_sampled(bvh, mesh, 100);
    CHECK(estimate.value == 0.0);
    CHECK(estimate.standard_error == 0.0);
    CHECK(end_point_overlap_sampled({}, {}, 100).value == 0.0);
}

TEST_CASE("EPO does not depend on numbering, threads, progress or powers of two") {
    const Mesh mesh = generate_scene("clustered", 20000);
    const Bvh bvh = Builder("locally-ordered").build(mesh);
    const double value = end_point_overlap(bvh, mesh);
    CHECK(value > 1.0);
    const Bvh other = renumbered(bvh);
    CHECK(other.nodes != bvh.nodes);
    CHECK(end_point_overlap(other, mesh) == value);
    const double estimate = end_point_overlap_sampled(bvh, mesh, 20000).value;
    const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
    for (const int threads : {1, 2, 4}) {
        tbb::task_arena(threads).execute([&] {
            CHECK(end_point_overlap(bvh, mesh) == value);
            CHECK(end_point_overlap_sampled(bvh, mesh, 20000).value == estimate);
        });
    }
    double before = 0.0;
    const auto watch = [&](const Progress& progress) {
        CHECK(progress.stage == "epo");
        CHECK(progress.fraction >= std::exchange(before, progress.fraction));
        return true;
    };
    CHECK(end_point_overlap(bvh, mesh, {}, watch) == value);
    CHECK(before == 1.0);
    for (const float scale : {largest_scale(mesh), 0x1p-60f}) {
        CHECK(end_point_overlap(scaled(bvh, scale), clbvh::test::scaled(mesh, scale)) == value);
    }
}

TEST_CASE("samples come as close to EPO as their error says") {
    for (const char* scene : {"city", "sphere", "clustered"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        for (const char* id : {"median", "sbvh"}) {
            const Bvh bvh = Builder(id).build(mesh);
            const double exact = end_point_overlap(bvh, mesh, {1.0, 2.0});
            double squares = 0.0;
            for (std::uint64_t seed = 1; seed <= 10; ++seed) {
                const Estimate estimate = end_point_overlap_sampled(bvh, mesh, 10000, seed, {1.0, 2.0});
                const double errors = (estimate.value - exact) / estimate.standard_error;
                CHECK(std::abs(errors) < 4.5);
                squares += errors * errors;
            }
            // Chi-squared with 10 degrees of freedom: beyond these once in ten thousand times each.
            CHECK(squares > 0.9);
            CHECK(squares < 35.6);
        }
    }
    const Mesh mesh = generate_scene("city", 3000);
    const Bvh bvh = Builder("median").build(mesh);
    const Estimate few = end_point_overlap_sampled(bvh, mesh, 1000);
    const Estimate many = end_point_overlap_sampled(bvh, mesh, 100000);
    CHECK(few.standard_error / many.standard_error == Approx(10.0).epsilon(0.2));
}

TEST_CASE("samples of neighbouring seeds have nothing to do with each other") {
    const Mesh mesh = generate_scene("city", 3000);
    const Bvh bvh = Builder("median").build(mesh);
    double squares = 0.0;
    Estimate before = end_point_overlap_sampled(bvh, mesh, 50000, 0);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const Estimate estimate = end_point_overlap_sampled(bvh, mesh, 50000, seed);
        const double errors = (estimate.value - before.value) / estimate.standard_error;
        squares += errors * errors;
        before = estimate;
    }
    // 20 is to be expected. Where neighbours share all samples but a few, it is next to nothing.
    CHECK(squares > 4.0);
}

TEST_CASE("very many triangles with the same box are no trouble") {
    const std::size_t count = 200000;
    const Mesh mesh = coincident_triangles(count);
    const Bvh bvh = Builder("locally-ordered").build(mesh);
    // Every node holds all triangles, of which each is foreign to all nodes but those above it.
    const double all_nodes = 1.2 * static_cast<double>(count - 1) + static_cast<double>(count);
    const TreeStatistics statistics = tree_statistics(bvh);
    REQUIRE(statistics.leaves == count);
    const double own = 1.2 * statistics.mean_leaf_depth() + 1.0;
    CHECK(end_point_overlap(bvh, mesh) == Approx(all_nodes - own).epsilon(1e-9));
    CHECK(end_point_overlap_sampled(bvh, mesh, 1000).value == Approx(all_nodes - own).epsilon(1e-3));
}

TEST_CASE("a tree as deep as it is large is no trouble") {
    const std::uint32_t count = 100000;
    const Mesh mesh = apart(count);
    Bvh bvh;
    bvh.nodes.resize(std::size_t{2} * count);
    bvh.primitive_count = count;
    bvh.primitive_ids.resize(count);
    std::iota(bvh.primitive_ids.begin(), bvh.primitive_ids.end(), 0U);
    Aabb rest;
    for (std::uint32_t i = count; i-- > 0;) {
        const Aabb own = triangle_bounds(mesh, i);
        rest = merge(rest, own);
        const std::uint32_t place = i == 0 ? 0 : 2 * i + 1;
        if (i + 1 == count) {
            bvh.nodes[place] = leaf(own, i, 1);
        } else {
            bvh.nodes[place] = inner(rest, 2 * i + 2);
            bvh.nodes[2 * i + 2] = leaf(own, i, 1);
        }
    }
    CHECK(end_point_overlap_sampled(bvh, mesh, 10).value == 0.0);
    const Mesh first{mesh.vertices, {mesh.triangles.begin(), mesh.triangles.begin() + 1}};
    expect_error(ErrorCode::invalid_input, {"primitive"}, [&] { (void)end_point_overlap(bvh, first); });
}

TEST_CASE("EPO refuses what is no tree over the mesh, and no cost") {
    const TwoSheets good(1.0f);
    const auto refused = [&](const std::string& part, const auto& spoil) {
        TwoSheets sheets(1.0f);
        spoil(sheets);
        expect_error(ErrorCode::invalid_input, {part}, [&] { (void)end_point_overlap(sheets.bvh, sheets.mesh); });
        expect_error(ErrorCode::invalid_input, {part},
                     [&] { (void)end_point_overlap_sampled(sheets.bvh, sheets.mesh, 10); });
    };
    refused("node 0: its children 4 and 5 are out of range", [](TwoSheets& s) { s.bvh.nodes[0].first = 4; });
    refused("node 0: its children 4294967294", [](TwoSheets& s) { s.bvh.nodes[0].first = 0xFFFFFFFEU; });
    refused("node 3: its primitive range ends at 3", [](TwoSheets& s) { s.bvh.nodes[3].count = 2; });
    refused("node 2: its primitive 2 is out of range", [](TwoSheets& s) { s.bvh.primitive_ids[0] = 2; });
    refused("node 2: its children 0 and 1 have another parent", [](TwoSheets& s) { s.bvh.nodes[2] = inner({}, 0); });
    refused("triangle 1", [](TwoSheets& s) { s.mesh.triangles[1][2] = 6; });
    refused("coordinate", [](TwoSheets& s) { s.mesh.vertices[0].x = std::numeric_limits<float>::infinity(); });
    expect_error(ErrorCode::invalid_input, {"a primitive is -1"}, [&] {
        (void)end_point_overlap(good.bvh, good.mesh, {1.0, -1.0});
    });
    for (const std::uint64_t samples : {std::uint64_t{0}, std::uint64_t{1}, kMostEpoSamples + 1}) {
        expect_error(ErrorCode::invalid_input, {std::to_string(samples) + " samples"},
                     [&] { (void)end_point_overlap_sampled(good.bvh, good.mesh, samples); });
    }
    expect_error(ErrorCode::cancelled, {"cancelled"},
                 [&] { (void)end_point_overlap(good.bvh, good.mesh, {}, [](const Progress&) { return false; }); });
}
