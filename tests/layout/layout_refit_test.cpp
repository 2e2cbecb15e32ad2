// Refits in place: layouts in depth-first order become what is made of the refitted tree, byte by byte; compressed ones
// keep their slots, on new grids.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/optimize/refit.hpp"
#include "layout/layout_checks.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Mesh twisted(Mesh mesh, float amount) {
    for (Vec3& v : mesh.vertices) {
        const float angle = amount * v.z, x = v.x, y = v.y;
        v = {std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y, -v.z};
    }
    return mesh;
}

Bvh refitted(Bvh bvh, const Primitives& primitives) {
    refit(bvh, primitives);
    return bvh;
}

template <typename Layout>
void check_same_as_of_refitted_tree(const Bvh& bvh, const Primitives& primitives) {
    const auto expected = make_layout<Layout>(refitted(bvh, primitives));
    for (const std::uint32_t threads : {0u, 1u}) {
        auto layout = make_layout<Layout>(bvh);
        refit(layout, primitives, {.thread_count = threads, .check = threads == 0});
        CHECK(same_elements(layout.nodes, expected.nodes));
        CHECK(same_elements(layout.primitive_ids, expected.primitive_ids));
    }
}

void check_depth_first(const Bvh& bvh, const Primitives& primitives) {
    check_same_as_of_refitted_tree<SkipLayout>(bvh, primitives);
    check_same_as_of_refitted_tree<PairLayout>(bvh, primitives);
}

/// The box of all triangles below a node.
Aabb box_below(const Compressed8& layout, std::uint32_t node, const Mesh& mesh);

Aabb box_in_slot(const Compressed8& layout, const Compressed8Node& node, std::uint32_t slot, const Mesh& mesh) {
    if (node.is_inner(slot)) return box_below(layout, node.child(slot), mesh);
    Aabb box;
    for (std::uint32_t i = 0; i < node.triangle_count(slot); ++i)
        box = merge(box, triangle_bounds(mesh, layout.triangles[node.triangle(slot) + i].primitive));
    return box;
}

Aabb box_below(const Compressed8& layout, std::uint32_t node, const Mesh& mesh) {
    Aabb box;
    for (std::uint32_t slot = 0; slot < 8; ++slot) {
        if (!layout.nodes[node].is_empty(slot)) box = merge(box, box_in_slot(layout, layout.nodes[node], slot, mesh));
    }
    return box;
}

/// Boxes on the grid that are not around what is below them, or larger than a step of the grid asks for.
std::size_t count_wrong_boxes(const Compressed8& layout, const Mesh& mesh) {
    std::size_t wrong = 0;
    for (const Compressed8Node& node : layout.nodes) {
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            if (node.is_empty(slot)) continue;
            const Aabb exact = box_in_slot(layout, node, slot, mesh), written = node.bounds(slot);
            const auto is_tight = [&](float outer, float inner, int exponent) {
                return std::abs(outer - inner) <= 1.001f * std::ldexp(1.0f, exponent) + 1e-6f * std::abs(inner);
            };
            const auto& e = node.exponent;
            const bool is_right =
                written.lower.x <= exact.lower.x && written.lower.y <= exact.lower.y &&
                written.lower.z <= exact.lower.z && written.upper.x >= exact.upper.x &&
                written.upper.y >= exact.upper.y && written.upper.z >= exact.upper.z &&
                is_tight(written.lower.x, exact.lower.x, e[0]) && is_tight(written.upper.x, exact.upper.x, e[0]) &&
                is_tight(written.lower.y, exact.lower.y, e[1]) && is_tight(written.upper.y, exact.upper.y, e[1]) &&
                is_tight(written.lower.z, exact.lower.z, e[2]) && is_tight(written.upper.z, exact.upper.z, e[2]);
            wrong += is_right ? 0 : 1;
        }
    }
    return wrong;
}

const std::vector<const char*> kBuilders = {"binned-sah", "sbvh", "median"};

}  // namespace

TEST_CASE("layout refit: skip and pair become what is made of the refitted tree") {
    for (const char* const scene : {"city", "hair", "soup"}) {
        const Mesh mesh = generate_scene(scene, 30'000);
        const Mesh moved = twisted(mesh, 0.3f);
        for (const char* const builder : kBuilders) {
            INFO(scene << ' ' << builder);
            check_depth_first(build(mesh, builder), Primitives{moved});
        }
    }
}

TEST_CASE("layout refit: odd trees in depth-first order") {
    for (const MeshTree& tree : odd_trees()) {
        INFO(tree.name);
        const Mesh moved = scaled(tree.mesh, 0.7f);
        check_depth_first(tree.bvh, Primitives{moved});
    }
    const Mesh line = line_of_points(100'000);
    for (const Mesh& frame : flat_and_other_frames(line))
        check_depth_first(chain_tree(line), Primitives{frame});
}

TEST_CASE("layout refit: trees over boxes in depth-first order") {
    const Mesh mesh = generate_scene("city", 5000), moved = twisted(mesh, 0.3f);
    std::vector<Aabb> boxes, moved_boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        boxes.push_back(triangle_bounds(mesh, i));
        moved_boxes.push_back(triangle_bounds(moved, i));
    }
    check_depth_first(build(BoxView(boxes), "binned-sah"), BoxView(moved_boxes));
}

TEST_CASE("layout refit: compressed8 is valid, its boxes fit, and rays hit what they hit in a tree") {
    for (const char* const scene : {"city", "hair", "soup"}) {
        const Mesh mesh = generate_scene(scene, 40'000);
        for (const char* const builder : kBuilders) {
            auto layout = make_layout<Compressed8>(build(mesh, builder), mesh);
            for (const float amount : {0.05f, 0.9f}) {
                INFO(scene << ' ' << builder << ' ' << amount);
                const Mesh moved = twisted(mesh, amount);
                refit(layout, moved, {.thread_count = amount > 0.1f ? 1u : 0u});
                CHECK_NOTHROW(validate(layout, moved));
                CHECK(count_wrong_boxes(layout, moved) == 0);
                CHECK(count_other_hits({"", moved, build(moved, "binned-sah")}, layout, 20) == 0);
            }
        }
    }
}

TEST_CASE("layout refit: compressed8 is what is made of the refitted tree where that asks for the same slots") {
    const Mesh mesh = generate_scene("city", 40'000);
    const Mesh larger = scaled(mesh, 2.0f);
    for (const char* const builder : kBuilders) {
        const Bvh bvh = refitted(build(mesh, builder), Primitives{mesh});
        auto layout = make_layout<Compressed8>(bvh, mesh);
        refit(layout, twisted(mesh, 0.5f));
        for (const Mesh& frame : {larger, mesh}) {
            refit(layout, frame);
            const auto expected = make_layout<Compressed8>(refitted(bvh, Primitives{frame}), frame);
            INFO(builder);
            CHECK(same_elements(layout.nodes, expected.nodes));
            CHECK(same_elements(layout.triangles, expected.triangles));
        }
    }
}

TEST_CASE("layout refit: odd trees, compressed") {
    for (const MeshTree& tree : odd_trees()) {
        INFO(tree.name);
        auto layout = make_layout<Compressed8>(tree.bvh, tree.mesh);
        const Mesh moved = scaled(tree.mesh, 0.7f);
        refit(layout, moved);
        CHECK_NOTHROW(validate(layout, moved));
    }
    const Mesh line = line_of_points(100'000);
    auto layout = make_layout<Compressed8>(chain_tree(line), line);
    for (const Mesh& frame : flat_and_other_frames(line)) {
        refit(layout, frame);
        CHECK_NOTHROW(validate(layout, frame));
    }
}

TEST_CASE("layout refit: primitives that are not the layout's are refused, and the layout stays") {
    const Mesh mesh = generate_scene("soup", 100), other = generate_scene("soup", 99);
    Mesh broken = mesh;
    broken.triangles[5][2] = 4000000000u;
    const Bvh bvh = build(mesh, "median");
    const auto check = [&](const auto& before) {
        auto layout = before;
        expect_error(ErrorCode::invalid_input, {"100 triangles", "99"}, [&] { refit(layout, other); });
        expect_error(ErrorCode::invalid_input, {"triangle 5"}, [&] { refit(layout, broken); });
        expect_error(ErrorCode::invalid_input, {"thread_count"}, [&] { refit(layout, mesh, {.thread_count = 1025}); });
        CHECK(same_elements(layout.nodes, before.nodes));
        auto empty = before;
        empty = {};
        refit(empty, Mesh{});
        CHECK(empty.empty());
    };
    check(make_layout<SkipLayout>(bvh));
    check(make_layout<PairLayout>(bvh));
    check(make_layout<Compressed8>(bvh, mesh));
    auto layout = make_layout<SkipLayout>(bvh);
    const std::vector<Aabb> boxes(7);
    expect_error(ErrorCode::invalid_input, {"100 boxes", "7 boxes"}, [&] { refit(layout, BoxView(boxes)); });
}

TEST_CASE("layout refit: a triangle that gets a NaN is left out, and comes back") {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    const Mesh mesh = generate_scene("soup", 500);
    const Bvh bvh = refitted(build(mesh, "median"), Primitives{mesh});
    Mesh holed = mesh, all_gone = mesh;
    for (const std::uint32_t vertex : holed.triangles[7])
        holed.vertices[vertex] = {nan, nan, nan};
    for (Vec3& vertex : all_gone.vertices)
        vertex = {nan, nan, nan};
    const auto check = [&](const auto& before) {
        auto layout = before;
        for (const Mesh& gone : {holed, all_gone}) {
            refit(layout, gone);
            std::size_t hits = 0;
            for (const Ray& ray : difficult_rays(mesh, 200)) {
                const Hit hit = closest_in(layout, gone, ray);
                hits += hit.primitive == 7 || (&gone == &all_gone && hit) ? 1 : 0;
            }
            CHECK(hits == 0);
        }
        refit(layout, mesh);
        CHECK(same_elements(layout.nodes, before.nodes));
    };
    check(make_layout<SkipLayout>(bvh));
    check(make_layout<PairLayout>(bvh));
    check(make_layout<Compressed8>(bvh, mesh));
}
