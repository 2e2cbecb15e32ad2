// Layouts of meshes that move: their boxes are the unions of what is below them, and rays find what they find in a
// layout that is made anew.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/wide.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/expect_error.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// The mesh, twisted about the z axis and stretched.
Mesh moved(Mesh mesh, float amount) {
    for (Vec3& v : mesh.vertices) {
        const float angle = amount * v.z, x = v.x, y = v.y;
        v.x = std::cos(angle) * x - std::sin(angle) * y;
        v.y = std::sin(angle) * x + std::cos(angle) * y;
        v.z *= 1.0f + 0.5f * amount;
    }
    return mesh;
}

template <std::uint32_t Width>
Aabb box_of(const WideNode<Width>& node, std::uint32_t slot) {
    return {{node.bounds[0][0][slot], node.bounds[0][1][slot], node.bounds[0][2][slot]},
            {node.bounds[1][0][slot], node.bounds[1][1][slot], node.bounds[1][2][slot]}};
}

/// The box around a child by definition: around its triangles, or around its own children.
template <std::uint32_t Width>
Aabb box_below(const WideLayout<Width>& layout, std::uint32_t child, const Mesh& mesh) {
    Aabb box;
    if (!WideChild::is_leaf(child)) {
        for (std::uint32_t slot = 0; slot < Width; ++slot)
            box = merge(box, box_of(layout.nodes[child], slot));
        return box;
    }
    for (std::uint32_t i = 0; i < WideChild::block_count(child); ++i) {
        for (const std::uint32_t primitive : layout.blocks[WideChild::first_block(child) + i].primitives) {
            if (primitive != kNoPrimitive) box = merge(box, triangle_bounds(mesh, primitive));
        }
    }
    return box;
}

template <std::uint32_t Width>
std::size_t count_wrong_boxes(const WideLayout<Width>& layout, const Mesh& mesh) {
    std::size_t wrong = 0;
    for (const WideNode<Width>& node : layout.nodes) {
        for (std::uint32_t slot = 0; slot < Width; ++slot) {
            const std::uint32_t child = node.children[slot];
            const Aabb expected = child == WideChild::kNone ? Aabb{} : box_below(layout, child, mesh);
            wrong += box_of(node, slot) == expected ? 0 : 1;
        }
    }
    return wrong;
}

}  // namespace

TEST_CASE("a refitted layout has the boxes that its triangles ask for") {
    for (const char* scene : {"city", "hair", "soup"}) {
        const Mesh mesh = generate_scene(scene, 5000);
        for (const char* id : {"binned-sah", "sbvh", "median"}) {
            const Bvh bvh = build(mesh, id);
            Wide8 wide8 = make_layout<Wide8>(bvh, mesh);
            Wide4 wide4 = make_layout<Wide4>(bvh, mesh);
            for (const float amount : {0.01f, 0.5f, -1.0f}) {
                const Mesh frame = moved(mesh, amount);
                refit(wide8, frame, {.thread_count = amount > 0.1f ? 1u : 0u});
                refit(wide4, frame);
                INFO(scene << ' ' << id << ' ' << amount);
                CHECK(count_wrong_boxes(wide8, frame) == 0);
                CHECK(count_wrong_boxes(wide4, frame) == 0);
            }
        }
    }
}

TEST_CASE("rays find in a refitted layout what they find in one made anew") {
    const Mesh mesh = generate_scene("city", 5000);
    Wide8 layout = make_layout<Wide8>(build(mesh, "binned-sah"), mesh);
    const Tracer tracer(std::as_const(layout));
    for (const float amount : {0.2f, -0.7f}) {
        const Mesh frame = moved(mesh, amount);
        refit(layout, frame);
        const Tracer expected(build(frame, "binned-sah"), frame);
        std::size_t differences = 0;
        for (const Ray& ray : difficult_rays(frame, 300)) {
            const bool agrees =
                same_bits(tracer.closest(ray), expected.closest(ray)) && tracer.any(ray) == expected.any(ray);
            differences += agrees ? 0 : 1;
        }
        CHECK(differences == 0);
    }
}

TEST_CASE("a refit to where the mesh was changes nothing but the sign of zeros") {
    const Mesh mesh = generate_scene("soup", 3000);
    const Wide8 before = make_layout<Wide8>(build(mesh, "binned-sah"), mesh);
    Wide8 after = before;
    refit(after, moved(mesh, 1.0f));
    refit(after, mesh);
    std::size_t differences = 0;
    for (std::size_t i = 0; i < before.nodes.size(); ++i)
        differences += before.nodes[i].bounds == after.nodes[i].bounds ? 0 : 1;
    CHECK(differences == 0);
    CHECK(std::memcmp(before.blocks.data(), after.blocks.data(), before.blocks.size() * sizeof(TriangleBlock)) == 0);
}

TEST_CASE("a mesh that is not the layout's is refused, and the layout stays") {
    const Mesh mesh = generate_scene("soup", 100);
    const Wide8 before = make_layout<Wide8>(build(mesh, "median"), mesh);
    Wide8 layout = before;
    Mesh other = generate_scene("soup", 99);
    expect_error(ErrorCode::invalid_input, {"100 triangles", "99"}, [&] { refit(layout, other); });
    other = mesh;
    other.triangles[5][2] = 4000000000u;
    expect_error(ErrorCode::invalid_input, {"triangle 5"}, [&] { refit(layout, other); });
    CHECK(std::memcmp(before.nodes.data(), layout.nodes.data(), before.nodes.size() * sizeof(WideNode<8>)) == 0);
    Wide8 empty;
    refit(empty, Mesh{});
    CHECK(empty.empty());
}

TEST_CASE("a triangle that gets a NaN is left out, and comes back") {
    const Mesh mesh = generate_scene("soup", 500);
    Wide8 layout = make_layout<Wide8>(build(mesh, "median"), mesh);
    Mesh holed = mesh;
    for (const std::uint32_t vertex : holed.triangles[7])
        holed.vertices[vertex].x = holed.vertices[vertex].y = holed.vertices[vertex].z =
            std::numeric_limits<float>::quiet_NaN();
    refit(layout, holed);
    const Tracer tracer(std::as_const(layout));
    std::size_t wrong = 0;
    for (const Ray& ray : difficult_rays(mesh, 200))
        wrong += tracer.closest(ray).primitive == 7 ? 1 : 0;
    CHECK(wrong == 0);
    refit(layout, mesh);
    CHECK(count_wrong_boxes(layout, mesh) == 0);
}
