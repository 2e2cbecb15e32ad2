// Views of the caller's arrays: whatever the layout, every builder and everything behind it gives the bytes that it
// gives for a mesh, or for boxes, of its own kind; and nothing is copied on the way.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "clbvh/clbvh.hpp"
#include "clbvh/io/scene.hpp"
#include "core/coverage.hpp"
#include "support/allocations.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/fitted_by_definition.hpp"
#include "support/meshes.hpp"
#include "support/views.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::vector<std::string> all_builders() {
    std::vector<std::string> ids;
    for (const BuilderInfo& builder : builders())
        if (can_run(builder.id)) ids.emplace_back(builder.id);
    return ids;
}

/// Boxes, of which some are inactive.
std::vector<Aabb> boxes() {
    std::vector<Aabb> result = random_boxes(1500);
    result[3].lower.x = std::numeric_limits<float>::quiet_NaN();
    result[1200].upper.z = std::numeric_limits<float>::quiet_NaN();
    return result;
}

}  // namespace

TEST_CASE("views: every builder gives the same bytes for every layout of triangles", "[views]") {
    const Mesh mesh = mesh_with_inactive();
    const std::vector<ViewedMesh> layouts = layouts_of(mesh);
    REQUIRE(layouts.size() == 25);
    for (const std::string& id : all_builders()) {
        Builder builder = make_builder(id);
        const Bvh expected = builder.build(mesh);
        for (const ViewedMesh& layout : layouts) {
            INFO(id << ", " << layout.name);
            CHECK(same_bytes(builder.build(layout.view), expected));
        }
    }
}

TEST_CASE("views: every builder gives the same bytes for every layout of boxes", "[views]") {
    const std::vector<Aabb> set = boxes();
    const std::vector<ViewedBoxes> layouts = layouts_of(set);
    const Mesh lines = mesh_of_boxes(set);
    for (const std::string& id : all_builders()) {
        Builder builder = make_builder(id);
        BuildStats stats;
        const Bvh expected = builder.build(set, &stats);
        CHECK(stats.inactive_primitives == 2);
        CHECK(validate(expected, set).error.empty());
        for (const ViewedBoxes& layout : layouts) {
            INFO(id << ", " << layout.name);
            CHECK(same_bytes(builder.build(layout.view), expected));
        }
        INFO(id);
        if (id != "sbvh") CHECK(same_bytes(builder.build(lines), expected));
    }
}

TEST_CASE("views: splitting before the builder, in every layout", "[views]") {
    const Mesh mesh = mesh_with_inactive();
    BuildOptions by_edges, to_quota;
    by_edges.presplit_level = 12;
    to_quota.split_quota = 0.5f;
    for (const char* const id : {"sbvh", "median", "lbvh"}) {
        if (!can_run(id)) continue;
        for (const BuildOptions& options : {by_edges, to_quota}) {
            Builder builder = make_builder(id, options);
            const Bvh expected = builder.build(mesh);
            CHECK(expected.split_references);
            for (const ViewedMesh& layout : layouts_of(mesh)) {
                INFO(id << ", " << layout.name);
                CHECK(same_bytes(builder.build(layout.view), expected));
            }
            expect_error(ErrorCode::unsupported, {"splits triangles, but boxes were given"},
                         [&] { (void)builder.build(boxes()); });
        }
    }
    const PresplitMesh expected = presplit(mesh, {12});
    for (const ViewedMesh& layout : layouts_of(mesh)) {
        if (layout.view.indices == nullptr) continue;  // which has other vertices
        const PresplitMesh split = presplit(layout.view, {12});
        CHECK(split.source == expected.source);
        CHECK(split.mesh.triangles == expected.mesh.triangles);
    }
}

TEST_CASE("views: validation, refits, rays and end-point overlap in every layout", "[views]") {
    const Mesh mesh = mesh_with_inactive();
    const Bvh tree = make_builder("sbvh").build(mesh);
    const Bvh fitted = fitted_by_definition(tree, mesh);
    const Tracer tracer(tree, mesh);
    const std::vector<Ray> rays = rays_to_vertices(tree.nodes[0].bounds(), mesh);
    const double overlap = end_point_overlap(tree, mesh);
    for (const ViewedMesh& layout : layouts_of(mesh)) {
        INFO(layout.name);
        CHECK(validate(tree, layout.view).error.empty());
        Bvh moved = tree;
        refit(moved, layout.view);
        CHECK(same_bytes(moved, fitted));
        const Tracer other(tree, layout.view);
        std::size_t found = 0;
        for (const Ray& ray : rays) {
            const Hit hit = tracer.closest(ray);
            found += hit ? 1 : 0;
            CHECK(other.closest(ray) == hit);
        }
        CHECK(found > 20);
        CHECK(end_point_overlap(tree, layout.view) == overlap);
    }
}

TEST_CASE("views: refits over boxes give every node the boxes below it", "[views]") {
    std::vector<Aabb> set = boxes();
    for (const char* const id : {"binned-sah", "sbvh", "plocpp"}) {
        if (!can_run(id)) continue;
        const Bvh tree = make_builder(id).build(set);
        std::vector<Aabb> moved = set;
        for (std::size_t i = 0; i < moved.size(); ++i) {
            moved[i].lower.y -= static_cast<float>(i % 7);
            moved[i].upper.x += static_cast<float>(i % 5);
        }
        for (const ViewedBoxes& layout : layouts_of(moved)) {
            INFO(id << ", " << layout.name);
            Bvh refitted = tree;
            refit(refitted, layout.view);
            CHECK(same_bytes(refitted, fitted_by_definition(tree, moved)));
            CHECK(validate(refitted, layout.view).error.empty());
            CHECK_FALSE(validate(tree, layout.view).error.empty());
        }
        moved[40].upper.x = std::numeric_limits<float>::quiet_NaN();
        Bvh refitted = tree;
        expect_error(ErrorCode::invalid_input, {"box 40 has a NaN now"}, [&] { refit(refitted, moved); });
        moved.pop_back();
        expect_error(ErrorCode::invalid_input, {"there are 1499 boxes", "over 1500"}, [&] { refit(refitted, moved); });
    }
}

TEST_CASE("views: validate finds what is wrong with trees over boxes", "[views]") {
    const std::vector<Aabb> set = boxes();
    const Bvh tree = make_builder("binned-sah").build(set);
    const auto error_of = [](const Bvh& bvh, const Primitives& primitives) { return validate(bvh, primitives).error; };
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        if (i == 1) continue;
        Bvh broken = tree;
        broken.nodes[i].upper[0] += 0.25f;
        CHECK_FALSE(error_of(broken, set).empty());
    }
    Bvh broken = tree;
    broken.primitive_ids[0] = 3;
    CHECK(error_of(broken, set).find("primitive 3 is inactive") != std::string::npos);
    CHECK(error_of(tree, std::span(set).first(1000)).find("there are 1000 boxes") != std::string::npos);
    std::vector<Aabb> inverted = set;
    inverted[17].lower.y = inverted[17].upper.y + 1.0f;
    CHECK(error_of(tree, inverted).find("the boxes are not valid: box 17") != std::string::npos);
}

TEST_CASE("views: validate finds parts of boxes that are lost", "[views]") {
    // Two heaps, and long boxes from one to the other.
    std::vector<Aabb> set = random_boxes(400);
    for (std::size_t i = 0; i < set.size(); ++i) {
        const float shift = i % 2 == 0 ? -5000.0f : 5000.0f;
        set[i].lower.x += shift;
        set[i].upper.x += shift;
    }
    for (const float y : {-1.0f, 0.0f, 1.0f})
        set.push_back({{-5000, y, 0}, {5000, y + 0.5f, 0.5f}});
    const Bvh tree = make_builder("sbvh").build(set);
    REQUIRE(tree.split_references);
    REQUIRE(tree.primitive_ids.size() > set.size());
    CHECK(validate(tree, set).error.empty());
    std::vector<std::uint32_t> leaves;
    for (std::uint32_t i = 0; i < tree.nodes.size(); ++i) {
        if (tree.nodes[i].is_leaf()) leaves.push_back(i);
    }
    CHECK_FALSE(find_lost_part(tree, set, leaves));
    for (const std::uint32_t index : leaves) {
        Bvh broken = tree;
        Node& leaf = broken.nodes[index];
        leaf.upper[0] = 0.5f * (leaf.lower[0] + leaf.upper[0]);
        if (leaf.upper[0] == tree.nodes[index].upper[0]) continue;
        const auto lost = find_lost_part(broken, set, leaves);
        REQUIRE(lost);
        const auto ids = std::span(tree.primitive_ids).subspan(leaf.first, leaf.count);
        CHECK(std::ranges::count(ids, lost->primitive) == 1);
    }
}

TEST_CASE("views: errors name the first offender, and what a view cannot be", "[views]") {
    const Mesh mesh = generate_scene("city", 1000);
    for (ViewedMesh& layout : layouts_of(mesh)) {
        INFO(layout.name);
        if (layout.view.indices != nullptr) {
            const Triangle triangle = layout.view.triangle(500);
            layout.view.vertex_count = triangle[1];
            expect_error(ErrorCode::invalid_input, {"vertex index ", "is out of range"},
                         [&] { (void)check_mesh(layout.view); });
            layout.view.vertex_count = mesh.vertices.size();
        }
        const std::size_t place = layout.view.triangle(300)[1] * layout.view.vertex_stride / sizeof(float);
        const_cast<float*>(layout.view.vertices)[place + 1] = -std::numeric_limits<float>::infinity();
        expect_error(ErrorCode::invalid_input, {"triangle ", ": coordinate y of vertex ", "is -inf"},
                     [&] { (void)check_mesh(layout.view); });
    }
    std::vector<Aabb> set = random_boxes(100);
    const auto expect_refused = [](const std::string& what, const Primitives& primitives) {
        expect_error(ErrorCode::invalid_input, {what}, [&] { (void)check_primitives(primitives); });
        expect_error(ErrorCode::invalid_input, {what}, [&] { (void)build_median(primitives); });
    };
    set[60].upper.z = 2e18f;
    expect_refused("box 60: coordinate z of its upper corner is 2e+18", set);
    set[40] = Aabb{};
    expect_refused("box 40: coordinate x of its lower corner is inf", set);
    set[30].lower.y = set[30].upper.y + 1;
    expect_refused("box 30: its lower corner is above its upper one", set);
    MeshView view = mesh;
    view.vertex_stride = 14;
    expect_refused("the stride of the vertices is 14 bytes; it must be a multiple of 4 and at least 12", view);
    view.vertex_stride = 8;
    expect_refused("the stride of the vertices is 8 bytes", view);
    view = mesh;
    view.index_stride = 8;
    expect_refused("the stride of the indices is 8 bytes; it must be a multiple of 4 and at least 12", view);
    view = mesh;
    view.vertices = reinterpret_cast<const float*>(reinterpret_cast<const char*>(mesh.vertices.data()) + 2);
    expect_refused("the vertices do not begin at a multiple of 4 bytes", view);
    view.vertices = nullptr;
    expect_refused("the vertices are at a null pointer", view);
    view = mesh;
    view.indices = nullptr;
    view.vertex_count = 3 * view.triangle_count - 1;
    expect_refused("vertices are too few for", view);
    expect_refused("the stride of the boxes is 20 bytes", BoxView(&set[0].lower.x, 2, 20));
    expect_refused("the boxes are at a null pointer", BoxView(nullptr, 2));
}

TEST_CASE("views: host builds copy nothing of the caller's", "[views]") {
    const Mesh mesh = generate_scene("city", 20000);
    constexpr std::size_t large = 60000;  // bytes: less than the ids, the vertices and the indices
    for (const std::string_view id : host_builders()) {
        Builder builder{id};
        INFO(id);
        static_cast<void>(builder.build(mesh));  // the builder keeps the memory of its tree
        CHECK(allocations_of(large, [&] { builder.upload(mesh); }) == 0);
        CHECK(allocations_of(large, [&] { builder.run(); }) == 0);
        // The copy that is handed out: nodes and ids.
        CHECK(allocations_of(large, [&] { static_cast<void>(builder.build(mesh)); }) == 2);
    }
}
