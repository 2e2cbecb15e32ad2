// What the statistics of a build say, and what they prove about the algorithms: launches and rounds.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/surface_ray_cost.hpp"
#include "device/build/stage_bench.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"
#include "support/oracle/tree_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

BuildStats stats_of(Builder& builder, const Mesh& mesh) {
    BuildStats stats;
    (void)builder.build(mesh, &stats);
    return stats;
}

/// Launches of the cluster stage beside those of the iterations.
std::int64_t launches_beside_iterations(const BuildStats& stats, std::int64_t per_iteration) {
    return std::int64_t{stage(stats, "cluster").launches} - per_iteration * std::int64_t{stats.iterations};
}

/// Checks that the cluster stage takes this many launches an iteration and the same number beside, whatever the size.
/// Iterations are launched several at a time, and the last few may find nothing left to do.
void expect_launches_per_iteration(std::string_view id, std::int64_t per_iteration) {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        BuildOptions options = options_of(shape);
        options.ploc.single_group_threshold = 500;
        Builder builder = make_builder(id, options);
        const BuildStats small = stats_of(builder, generate_scene("soup", 2000));
        const BuildStats large = stats_of(builder, generate_scene("terrain", 100000));
        INFO(id << ", " << to_string(shape));
        CHECK(small.iterations >= 2);
        CHECK(large.iterations > small.iterations);
        const std::int64_t beside_small = launches_beside_iterations(small, per_iteration);
        const std::int64_t beside_large = launches_beside_iterations(large, per_iteration);
        const std::int64_t most_idle = per_iteration * (std::int64_t{settings_of(options).iterations_in_flight} - 1);
        for (const std::int64_t beside : {beside_small, beside_large}) {
            CHECK(beside >= 0);
            CHECK(beside <= 4 + most_idle);
        }
        CHECK((beside_large - beside_small) % per_iteration == 0);
    }
}

}  // namespace

TEST_CASE("ploc launches five kernels an iteration") {
    expect_launches_per_iteration("ploc", 5);
}

TEST_CASE("plocpp launches two kernels an iteration before the single work group") {
    expect_launches_per_iteration("plocpp", 2);
}

TEST_CASE("plocpp needs no iteration below the threshold of the single work group") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        Builder builder = make_builder("plocpp", options_of(shape));
        const BuildStats stats = stats_of(builder, generate_scene("soup", 8000));
        CHECK(stats.iterations == 0);
        CHECK(stats.clusters_per_iteration.empty());
    }
}

TEST_CASE("plocpp-two-level, hploc and lbvh launch the same number of kernels whatever the size") {
    // Codes are made again in one launch where the sort has one piece, in nine else.
    constexpr std::uint32_t kSparedLaunches = 8;
    for (const std::string_view id : {"plocpp-two-level", "hploc", "lbvh"}) {
        for (const Shape shape : {Shape::group, Shape::lane}) {
            Builder builder = make_builder(id, options_of(shape));
            const BuildStats small = stats_of(builder, generate_scene("soup", 2000));
            INFO(id << ", " << to_string(shape));
            CHECK(small.iterations == 0);
            for (const std::string_view scene : {"soup", "particles", "city"}) {
                const BuildStats large = stats_of(builder, generate_scene(scene, 150000));
                CHECK(stage(large, "cluster").launches == stage(small, "cluster").launches);
                CHECK(stage(large, "sort").launches == stage(small, "sort").launches + kSparedLaunches);
                CHECK(large.launches == small.launches + kSparedLaunches);
            }
        }
    }
}

TEST_CASE("clusters per iteration are those of the definition") {
    for (const std::string_view id : {"ploc", "plocpp"}) {
        for (const Shape shape : {Shape::group, Shape::lane}) {
            for (const std::string_view scene : {"soup", "particles", "line"}) {
                BuildOptions options = options_of(shape, 8);
                options.ploc.single_group_threshold = 300;
                Builder builder = make_builder(id, options);
                const Mesh mesh = generate_scene(scene, 10000);
                const BuildStats stats = stats_of(builder, mesh);
                const auto& counts = stats.clusters_per_iteration;
                INFO(id << ", " << to_string(shape) << ", " << scene);
                REQUIRE(counts.size() == stats.iterations);
                REQUIRE_FALSE(counts.empty());
                CHECK(std::adjacent_find(counts.begin(), counts.end(), std::less_equal<>()) == counts.end());

                auto expected = oracle_tree(id, morton_order(mesh, options), options).clusters_per_iteration;
                if (id == "plocpp") {
                    std::erase_if(expected, [&](std::uint32_t count) { return count < counts.back(); });
                    CHECK(counts.back() > options.ploc.single_group_threshold);
                }
                CHECK(counts == expected);
            }
        }
    }
}

TEST_CASE("100,000 equal boxes take a logarithmic number of iterations, and make a shallow tree") {
    constexpr std::uint32_t count = 100000;
    constexpr std::uint32_t log_count = 17;
    static_assert(std::bit_width(count) == log_count);
    const Mesh mesh = coincident_triangles(count);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            BuildOptions options = options_of(shape);
            options.ploc.single_group_threshold = 2;
            Builder builder = make_builder(id, options);
            BuildStats stats;
            const Bvh bvh = builder.build(mesh, &stats);
            const ValidationReport report = validate(bvh, mesh);
            INFO(id << ", " << to_string(shape));
            CHECK(report.error == "");
            CHECK(report.depth <= 2 * log_count);
            CHECK(stats.iterations <= 2 * log_count);
        }
    }
}

TEST_CASE("stages have their names and order, and add up") {
    const Mesh mesh = generate_scene("soup", 50000);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            Builder builder = make_builder(id, options_of(shape));
            const BuildStats stats = stats_of(builder, mesh);
            INFO(id << ", " << to_string(shape));
            std::vector<std::string> names;
            std::uint32_t launches = 0;
            double host_ms = 0.0;
            for (const StageStats& stage : stats.stages) {
                names.push_back(stage.name);
                launches += stage.launches;
                host_ms += stage.host_ms;
                CHECK(stage.device_ms > 0.0);
                CHECK(stage.launches > 0);
            }
            CHECK(names == std::vector<std::string>{"bounds", "morton", "sort", "cluster", "root"});
            CHECK(launches == stats.launches);
            CHECK(host_ms > 0.0);
            CHECK(host_ms <= stats.build_ms);
            CHECK(stats.inactive_primitives == 0);
        }
    }
}

TEST_CASE("device memory of a build is at most 72 bytes a primitive beside the nodes, and 8 MiB") {
    constexpr std::uint64_t most_per_primitive = 72 + 2 * sizeof(Node);
    constexpr std::uint64_t least_per_primitive = 2 * sizeof(Node) + sizeof(std::uint32_t);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            Builder builder = make_builder(id, options_of(shape));
            for (const std::uint64_t count : {1000u, 300000u}) {
                const std::uint64_t bytes = stats_of(builder, generate_scene("soup", count)).peak_device_bytes;
                INFO(id << ", " << to_string(shape) << ", " << count);
                CHECK(bytes >= count * least_per_primitive);
                CHECK(bytes <= count * most_per_primitive + (8 << 20));
            }
        }
    }
}

TEST_CASE("on request, a build says what rays cost in its tree") {
    const Mesh mesh = generate_scene("city", 5000);
    for (const char* id : {"hploc", "binned-sah", "high", "highest"}) {
        if (!can_run(id)) continue;
        for (const float quota : {0.0f, 0.3f}) {
            INFO(id << ", quota " << quota);
            BuildOptions options;
            options.ray_cost = true;
            options.split_quota = quota;
            Builder builder = make_builder(id, options);
            BuildStats stats;
            const Bvh tree = builder.build(mesh, &stats);
            CHECK(stats.ray_cost == surface_ray_cost(tree, mesh).cost);
            CHECK(stats.stages.back().name == "ray-cost");
        }
    }
    BuildStats stats;
    BuildOptions options;
    static_cast<void>(make_builder("binned-sah", options).build(mesh, &stats));
    CHECK(stats.ray_cost == 0.0);
    options.ray_cost = true;
    Builder builder = make_builder("binned-sah", options);
    static_cast<void>(builder.build(mesh, &stats));
    static_cast<void>(builder.build(random_boxes(100), &stats));
    CHECK(stats.ray_cost == 0.0);
}

TEST_CASE("statistics of empty inputs are zero, not stale") {
    for (const std::string_view id : device_builders()) {
        Builder builder = make_builder(id, options_of(Shape::lane));
        (void)stats_of(builder, generate_scene("soup", 30000));
        for (Mesh mesh : {Mesh{}, random_triangles(5)}) {
            deactivate_triangles(mesh);
            const BuildStats stats = stats_of(builder, mesh);
            CHECK(stats.iterations == 0);
            CHECK(stats.clusters_per_iteration.empty());
            CHECK(stats.inactive_primitives == mesh.triangles.size());
        }
    }
}
