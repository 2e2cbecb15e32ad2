// Contract of every host builder: a valid tree, the same bytes every time and on any number of threads, on every
// generated scene at small and large sizes, and on the inputs that are hardest for it. No device is needed.
#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "clbvh/core/error.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Builder with_threads(std::string_view id, std::uint32_t threads) {
    BuildOptions options;
    options.thread_count = threads;
    return Builder(id, options);
}

/// Boxes hold none, so that equal trees are equal bytes.
bool has_negative_zero(const Node& node) {
    const auto is_one = [](float value) { return value == 0.0f && std::signbit(value); };
    return std::ranges::any_of(node.lower, is_one) || std::ranges::any_of(node.upper, is_one);
}

/// A sequential builder and one of four threads, even where there are fewer cores, with their memory from one mesh to
/// the next.
class Pair {
public:
    explicit Pair(std::string_view id) : id_(id), sequential_(with_threads(id, 1)), parallel_(with_threads(id, 4)) {}

    /// Returns false after the first failed check, so that a loop can stop.
    bool check(const Mesh& mesh, const std::string& where) {
        INFO(id_ << ", " << where);
        const Bvh bvh = sequential_.build(mesh);
        const bool same = same_bytes(parallel_.build(mesh), bvh);
        const std::string fault = validate(bvh, mesh).error;
        const bool negative_zero = std::ranges::any_of(bvh.nodes, has_negative_zero);
        CHECK(same);
        CHECK(fault == "");
        CHECK_FALSE(negative_zero);
        return same && fault.empty() && !negative_zero;
    }

private:
    tbb::global_control four_threads_{tbb::global_control::max_allowed_parallelism, 4};
    std::string_view id_;
    Builder sequential_;
    Builder parallel_;
};

void check_everywhere(const Mesh& mesh, const std::string& where) {
    for (const std::string_view id : host_builders())
        Pair(id).check(mesh, where);
}

Vec3& corner(Mesh& mesh, std::size_t triangle, std::size_t which) {
    return mesh.vertices[mesh.triangles[triangle][which]];
}

/// Boxes of triangle i, all extents alike: `size(i)` around `place(i)`.
template <typename Place, typename Size>
Mesh triangles_at(std::size_t count, const Place& place, const Size& size) {
    Mesh mesh = random_triangles(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 p = place(i);
        const float s = size(i);
        corner(mesh, i, 0) = p;
        corner(mesh, i, 1) = {p.x + s, p.y + s, p.z};
        corner(mesh, i, 2) = {p.x, p.y + s, p.z + s};
    }
    return mesh;
}

}  // namespace

TEST_CASE("host builders: every generated scene at small sizes") {
    std::vector<std::uint32_t> sizes(34);
    std::iota(sizes.begin(), sizes.end(), 0u);
    sizes.insert(sizes.end(), {63, 64, 65, 100, 127, 128, 129, 255, 256, 257, 511, 512, 513, 777, 999, 1000});
    for (const std::string_view id : host_builders()) {
        Pair pair(id);
        for (const SceneGeneratorInfo& scene : scene_generators()) {
            for (const std::uint32_t size : sizes) {
                const std::string where = std::string(scene.name) + ":" + std::to_string(size);
                if (!pair.check(generate_scene(scene.name, size), where)) return;
            }
        }
    }
}

TEST_CASE("host builders: every generated scene at large sizes") {
    for (const std::string_view id : host_builders()) {
        Pair pair(id);
        for (const SceneGeneratorInfo& scene : scene_generators()) {
            for (const std::uint32_t size : {5000u, 70001u})
                pair.check(generate_scene(scene.name, size), std::string(scene.name) + ":" + std::to_string(size));
        }
    }
}

TEST_CASE("host builders: many equal boxes") {
    check_everywhere(coincident_triangles(100000), "100,000 equal boxes");
}

TEST_CASE("host builders: equal centroids of nested boxes") {
    const auto mesh = triangles_at(
        20000,
        [](std::size_t i) {
            const float half = static_cast<float>(i + 1) * 0.5f;
            return Vec3{-half, -half, -half};
        },
        [](std::size_t i) { return static_cast<float>(i + 1); });
    check_everywhere(mesh, "nested boxes");
}

TEST_CASE("host builders: points, points on a line, and one point") {
    const auto no_size = [](std::size_t) { return 0.0f; };
    const auto spread = triangles_at(
        20000,
        [](std::size_t i) {
            const auto f = static_cast<float>(i);
            return Vec3{std::sin(f), std::cos(1.7f * f), std::sin(2.3f * f)};
        },
        no_size);
    check_everywhere(spread, "points");
    const auto line = triangles_at(
        20000,
        [](std::size_t i) {
            return Vec3{static_cast<float>(i), 0.0f, 0.0f};
        },
        no_size);
    check_everywhere(line, "points on a line");
    const auto one = triangles_at(
        20000,
        [](std::size_t) {
            return Vec3{1.0f, 2.0f, 3.0f};
        },
        no_size);
    check_everywhere(one, "one point");
}

TEST_CASE("host builders: one huge box among tiny ones") {
    Mesh mesh = generate_scene("clustered", 20000);
    for (std::size_t which = 0; which < 3; ++which) {
        const float side = which == 1 ? 1e6f : -1e6f;
        corner(mesh, 0, which) = {side, which == 2 ? 1e6f : -1e6f, side};
    }
    check_everywhere(mesh, "one huge box");
}

TEST_CASE("host builders: places that grow exponentially") {
    const auto mesh = triangles_at(
        3000,
        [](std::size_t i) {
            return Vec3{std::ldexp(1.0f, static_cast<int>(i % 180) - 130), 0.0f, 0.0f};
        },
        [](std::size_t i) { return std::ldexp(0.1f, static_cast<int>(i % 180) - 130); });
    check_everywhere(mesh, "exponential");
}

TEST_CASE("host builders: coordinates at the ends of the range") {
    for (const float scale : {1e17f, 1e-15f, 1e-38f, std::numeric_limits<float>::denorm_min()}) {
        Mesh mesh = random_triangles(5000);
        for (Vec3& v : mesh.vertices)
            v = {v.x * scale / 1.05f, v.y * scale / 1.05f, v.z * scale / 1.05f};
        check_everywhere(mesh, "scale " + std::to_string(scale));
    }
    Mesh mesh = random_triangles(5000);
    mesh.vertices[0] = {kMaxCoordinate, -kMaxCoordinate, kMaxCoordinate};
    mesh.vertices[3] = {-kMaxCoordinate, kMaxCoordinate, -kMaxCoordinate};
    check_everywhere(mesh, "two outliers");
}

TEST_CASE("host builders: negative zeros and inactive primitives") {
    Mesh zeros = random_triangles(3000);
    for (std::size_t i = 0; i < zeros.vertices.size(); ++i) {
        if (i % 3 == 0) zeros.vertices[i].x = -0.0f;
        zeros.vertices[i].z = i % 2 == 0 ? -0.0f : 0.0f;
    }
    check_everywhere(zeros, "negative zeros");
    for (const std::size_t step : {1u, 2u, 3u, 50u}) {
        for (const std::size_t size : {1u, 2u, 65u, 30000u}) {
            Mesh mesh = random_triangles(size);
            deactivate_triangles(mesh, 0, step);
            check_everywhere(mesh, "each of " + std::to_string(step) + " inactive");
        }
    }
}

TEST_CASE("host builders: every one beats the object median") {
    for (const std::string_view scene : {"soup", "clustered", "city", "terrain", "hair"}) {
        const Mesh mesh = generate_scene(scene, 20000);
        BuildOptions options;
        options.max_leaf_size = 8;  // one rule for the leaves of all
        const double floor = sah_cost(Builder("median", options).build(mesh));
        for (const std::string_view id : host_builders()) {
            INFO(id << " on " << scene);
            CHECK(sah_cost(Builder(id, options).build(mesh)) <= floor);
        }
    }
}

TEST_CASE("host builders need no context, and say so") {
    for (const std::string_view id : host_builders()) {
        const Builder builder{id};
        CHECK(builder.info().id == id);
        CHECK(builder.shape() == Shape::automatic);
        try {
            static_cast<void>(builder.context());
            FAIL("no Error was thrown");
        } catch (const Error& error) {
            CHECK(error.code() == ErrorCode::unsupported);
            CHECK_THAT(error.what(), Catch::Contains(std::string(id)));
        }
    }
}

TEST_CASE("host builders book stages and memory") {
    const Mesh mesh = generate_scene("soup", 20000);
    for (const std::string_view id : host_builders()) {
        INFO(id);
        BuildStats stats;
        const Bvh bvh = Builder(id).build(mesh, &stats);
        REQUIRE(stats.stages.size() >= 3);
        CHECK(stats.stages.front().name == "bounds");
        double sum = 0.0;
        for (const StageStats& stage : stats.stages) {
            CHECK(stage.host_ms >= 0.0);
            CHECK(stage.launches == 0);
            sum += stage.host_ms;
        }
        CHECK(sum <= stats.build_ms);
        const std::uint64_t tree_bytes = bvh.nodes.size() * sizeof(Node) + bvh.primitive_ids.size() * 4;
        CHECK(stats.peak_host_bytes > tree_bytes);
        CHECK(stats.peak_host_bytes < 400 * bvh.primitive_ids.size());
        CHECK(stats.peak_device_bytes == 0);
    }
}
