// Codes again where many primitives share one: codes and ids equal the oracle's to the bit, in both shapes.
#include "device/build/recode.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "clbvh/core/vector.hpp"
#include "clbvh/io/scene.hpp"
#include "device/build/bounds.hpp"
#include "device/build/morton.hpp"
#include "device/build/radix_sort.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"
#include "support/oracle/morton_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::uint32_t kLongestRun = 32;

BuildOptions recode_options(Shape shape, std::uint32_t code_bits) {
    BuildOptions options = options_of(shape);
    options.device.sort_shape = shape;
    options.device.code_bits = code_bits;
    return options;
}

/// Runs the stages up to the sort, and compares what stands there then.
void expect_oracle_order(const Mesh& mesh, const device::BuildSettings& settings, const MortonOrder& expected) {
    INFO(mesh.triangles.size() << " triangles, " << to_string(settings.sort_shape) << ", "
                               << settings.configs.device.code_bits << " code bits");
    StageBench bench(settings, mesh.triangles.size());
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    const device::DeviceMesh input = upload_mesh(bench.session, mesh);
    device::launch_bounds(bench.launcher, settings, bench.buffers, input);
    device::launch_morton(bench.launcher, settings, bench.buffers, count);
    device::launch_radix_sort(bench.launcher, settings, bench.buffers, count);
    device::launch_recode(bench.launcher, settings, bench.buffers, count);
    const auto ids = read<std::uint32_t>(bench.buffers.primitive_ids, expected.ids.size());
    const auto codes = read<std::uint64_t>(bench.buffers.codes, expected.codes.size());
    CHECK(std::ranges::mismatch(ids, expected.ids).in1 - ids.begin() == std::ssize(ids));
    CHECK(std::ranges::mismatch(codes, expected.codes).in1 - codes.begin() == std::ssize(codes));
}

void expect_oracle_order(const Mesh& mesh) {
    for (const std::uint32_t code_bits : {33u, 44u}) {
        const MortonOrder expected = morton_order(mesh, MortonCode::cubic, code_bits);
        CHECK(std::ranges::is_sorted(expected.codes));
        CHECK(std::ranges::adjacent_find(expected.codes) == expected.codes.end());
        for (const Shape shape : kBothShapes)
            expect_oracle_order(mesh, settings_of(recode_options(shape, code_bits)), expected);
    }
}

/// Adds a triangle of no size there.
void push_point(Mesh& mesh, const Vec3& at) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(at);
    mesh.triangles.push_back({first, first, first});
}

Vec3 random_point(std::mt19937& random, float scale) {
    const auto uniform = [&] { return static_cast<float>(random() >> 8) / 16777216.0f * scale; };
    const float x = uniform(), y = uniform(), z = uniform();
    return {x, y, z};
}

/// `clusters` times `size` points within an extent that a cell of the whole contains, at random places.
Mesh crowded_cells(std::uint32_t clusters, std::uint32_t size, float extent) {
    std::mt19937 random(7);
    Mesh mesh;
    for (std::uint32_t c = 0; c < clusters; ++c) {
        const Vec3 centre = random_point(random, 1.0f);
        for (std::uint32_t i = 0; i < size; ++i)
            push_point(mesh, centre + random_point(random, extent));
    }
    return mesh;
}

}  // namespace

TEST_CASE("recode: runs around the length from which they are coded again") {
    for (const std::uint32_t size : {kLongestRun - 1, kLongestRun, kLongestRun + 1, kLongestRun + 2, 100u}) {
        for (const std::uint32_t clusters : {1u, 2u, 50u, 400u}) {
            INFO(clusters << " cells of " << size);
            Mesh mesh = crowded_cells(clusters, size, 1e-6f);
            expect_oracle_order(mesh);
            push_point(mesh, {1, 1, 1});  // the cells' neighbour
            expect_oracle_order(mesh);
        }
    }
}

TEST_CASE("recode: one far triangle, or one farther still") {
    for (const std::string distance : {"10", "1e3", "1e5", "1e12"}) {
        INFO(distance);
        Mesh mesh = generate_scene("outlier:" + distance, 6000);
        expect_oracle_order(mesh);
        push_point(mesh, {-1e17f, 0, 0});
        expect_oracle_order(mesh);
    }
}

TEST_CASE("recode: scenes of very different scales") {
    for (const std::string name :
         {"mixed:2", "mixed:8", "two-objects:1e7", "two-objects:1e9", "planet", "sky", "planes", "city", "line"}) {
        INFO(name);
        expect_oracle_order(generate_scene(name, 20011));
    }
}

TEST_CASE("recode: equal centroids stay in the order of their ids") {
    Mesh mesh;
    for (std::uint32_t i = 0; i < 5000; ++i)
        push_point(mesh, {1, 2, 3});
    expect_oracle_order(mesh);
    push_point(mesh, {2e6f, 0, 0});
    push_point(mesh, {1.0000001f, 2, 3});
    expect_oracle_order(mesh);
    expect_oracle_order(generate_scene("particles", 10000));
}

TEST_CASE("recode: inactive primitives, which share the largest code, are no run") {
    Mesh mesh = generate_scene("outlier:1e6", 4000);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({nan, 0, 0});
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
        mesh.triangles[i] = {first, first, first};
    expect_oracle_order(mesh);
}

TEST_CASE("recode: runs across the pieces of a large device, and small work groups") {
    const Mesh mesh = generate_scene("two-objects:1e9", 100000);
    for (const std::uint32_t code_bits : {33u, 44u}) {
        const MortonOrder expected = morton_order(mesh, MortonCode::cubic, code_bits);
        for (const Shape shape : kBothShapes)
            expect_oracle_order(mesh, large_device_settings(recode_options(shape, code_bits)), expected);
        expect_oracle_order(mesh, small_group_settings(recode_options(Shape::group, code_bits), 32), expected);
    }
}
