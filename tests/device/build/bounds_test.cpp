// The stage `bounds` against the host: every box to the bit, NaNs for inactive primitives, and the bounds of the rest.
#include "device/build/bounds.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"
#include "support/oracle/morton_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct BoundsResult {
    std::vector<Aabb> boxes;
    SceneBounds scene;
    std::uint32_t leaf_count;
};

BoundsResult run_bounds(const Mesh& mesh, const device::BuildSettings& settings) {
    StageBench bench(settings, mesh.triangles.size());
    write(bench.buffers.primitive_count, std::vector<std::uint32_t>{12345});
    device::launch_bounds(bench.launcher, bench.settings, bench.buffers, upload_mesh(bench.session, mesh));
    const std::vector<Aabb> scene = read<Aabb>(bench.buffers.bounds, 2);
    return {read<Aabb>(bench.buffers.boxes, mesh.triangles.size()),
            {scene[0], scene[1]},
            read<std::uint32_t>(bench.buffers.primitive_count, 1)[0]};
}

bool is_all_nan(const Aabb& box) {
    const auto all_nan = [](const Vec3& v) { return std::isnan(v.x) && std::isnan(v.y) && std::isnan(v.z); };
    return all_nan(box.lower) && all_nan(box.upper);
}

/// The first primitive whose box is not the host's; as many as there are where all are.
std::size_t first_wrong_box(const std::vector<Aabb>& boxes, const ActivePrimitives& active) {
    std::size_t next_active = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const bool is_active = next_active < active.ids.size() && active.ids[next_active] == i;
        const bool right = is_active ? is_same_bits(boxes[i], active.bounds[next_active]) : is_all_nan(boxes[i]);
        if (!right) return i;
        next_active += is_active ? 1 : 0;
    }
    return boxes.size();
}

void expect_host_bounds(const Mesh& mesh, const device::BuildSettings& settings) {
    const ActivePrimitives active = active_primitives(mesh);
    const SceneBounds expected = scene_bounds(active.bounds);
    INFO(to_string(settings.shape) << ", " << mesh.triangles.size() << " primitives, " << active.ids.size()
                                   << " active");
    const BoundsResult result = run_bounds(mesh, settings);
    CHECK(first_wrong_box(result.boxes, active) == result.boxes.size());
    CHECK(result.leaf_count == active.ids.size());
    CHECK(is_same_bits(result.scene.primitives, expected.primitives));
    CHECK(is_same_bits(result.scene.doubled_centroids, expected.doubled_centroids));
}

void expect_host_bounds(const Mesh& mesh) {
    for (const Shape shape : kBothShapes)
        expect_host_bounds(mesh, settings_of(options_of(shape)));
}

}  // namespace

TEST_CASE("bounds: boxes and scene equal the host's at sizes around vectors, groups and pieces") {
    for (const std::size_t size :
         {1u, 2u, 15u, 16u, 17u, 255u, 256u, 257u, 1023u, 1024u, 1025u, 4095u, 4096u, 4097u, 30001u}) {
        expect_host_bounds(random_triangles(size));
    }
}

TEST_CASE("bounds: inactive primitives are NaNs and count for nothing") {
    for (const std::size_t size : {2u, 17u, 257u, 5000u}) {
        for (const std::size_t step : {2u, 3u, 50u}) {
            Mesh mesh = random_triangles(size);
            deactivate_triangles(mesh, 0, step);
            expect_host_bounds(mesh);
        }
    }
}

TEST_CASE("bounds: one active primitive among many is the scene") {
    for (const std::size_t active : {0u, 1u, 300u, 999u}) {
        Mesh mesh = random_triangles(1000);
        const Mesh whole = mesh;
        deactivate_triangles(mesh);
        for (const std::uint32_t vertex : mesh.triangles[active])
            mesh.vertices[vertex] = whole.vertices[vertex];
        expect_host_bounds(mesh);
    }
}

TEST_CASE("bounds: a NaN in any of the nine coordinates deactivates") {
    Mesh mesh = random_triangles(40);
    for (std::size_t i = 0; i < 9; ++i) {
        Vec3& vertex = mesh.vertices[mesh.triangles[4 * i][i / 3]];
        (i % 3 == 0 ? vertex.x : i % 3 == 1 ? vertex.y : vertex.z) = kNan;
    }
    REQUIRE(active_primitives(mesh).ids.size() == 31);
    expect_host_bounds(mesh);
}

TEST_CASE("bounds: vertices are shared, and zeros lose their sign") {
    Mesh mesh{{{-0.0f, 0.0f, -0.0f}, {1, -0.0f, 2}, {-0.0f, 3, -1}, {-0.0f, -0.0f, -0.0f}}, {}};
    for (std::uint32_t i = 0; i < 64; ++i)
        mesh.triangles.push_back({i % 4, i / 4 % 4, i / 16 % 4});
    expect_host_bounds(mesh);
    for (const Shape shape : kBothShapes) {
        const BoundsResult result = run_bounds({{{-0.0f, -0.0f, -0.0f}}, {{0, 0, 0}}}, settings_of(options_of(shape)));
        CHECK(is_same_bits(result.boxes[0], Aabb{{0, 0, 0}, {0, 0, 0}}));
        CHECK(is_same_bits(result.scene.doubled_centroids, Aabb{{0, 0, 0}, {0, 0, 0}}));
    }
}

TEST_CASE("bounds: the largest and the smallest coordinates") {
    Mesh mesh = random_triangles(500);
    mesh.vertices[3] = {kMaxCoordinate, -kMaxCoordinate, kMaxCoordinate};
    mesh.vertices[700] = {-kMaxCoordinate, kMaxCoordinate, -kMaxCoordinate};
    mesh.vertices[701] = {kMaxCoordinate, kMaxCoordinate, -kMaxCoordinate};
    mesh.vertices[702] = {kMaxCoordinate, kMaxCoordinate, -kMaxCoordinate};
    expect_host_bounds(mesh);
    for (Vec3& vertex : mesh.vertices)
        vertex = {vertex.x * 1e-18f, vertex.y * 1e-18f, vertex.z * 1e-18f};
    expect_host_bounds(mesh);
}

TEST_CASE("bounds: small work groups, and as many pieces as a large device takes") {
    const Mesh mesh = random_triangles(300000);
    for (const Shape shape : kBothShapes)
        expect_host_bounds(mesh, large_device_settings(options_of(shape)));
    for (const std::size_t size : {1u, 31u, 32u, 33u, 5000u}) {
        for (const std::size_t largest_group : {32u, 64u, 128u})
            expect_host_bounds(random_triangles(size), small_group_settings(options_of(Shape::group), largest_group));
    }
}
