// What is special about PLOC: its first pairs, exact distances, a search that ends at the radius, rounds of the host.
#include <catch2/catch.hpp>

#include "device/build/cluster_bench.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Chunks so small that little input fills many.
BuildOptions small_chunks(Shape shape, std::uint32_t radius) {
    BuildOptions options = options_of(shape, radius);
    options.ploc.chunk_size = 64;
    options.ploc.work_group_size = 256;
    return options;
}

std::uint32_t chunk_of(const BuildOptions& options) {
    const device::BuildSettings settings = settings_of(options);
    return settings.chunk_size(settings.configs.ploc.search_radius);
}

/// Sizes around one, two and many chunks.
std::vector<std::uint32_t> sizes_around_chunks(std::uint32_t chunk) {
    return {1, 2, 3, chunk - 1, chunk, chunk + 1, 2 * chunk - 1, 2 * chunk, 2 * chunk + 1, 40 * chunk + 1};
}

/// Cubes at one place whose lengths differ so little that distances of fewer bits confuse them.
std::vector<Aabb> nearly_equal_boxes(std::size_t count) {
    std::vector<Aabb> boxes;
    for (std::uint32_t i = 0; i < count; ++i) {
        const float length = 1.0f + static_cast<float>(i * 37 % 64) / 1048576.0f;
        boxes.push_back({{0, 0, 0}, {length, 1, 1}});
    }
    return boxes;
}

}  // namespace

TEST_CASE("ploc: the first round merges exactly the mutual pairs") {
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t radius : {1u, 5u, 16u, 32u}) {
            const BuildOptions options = small_chunks(shape, radius);
            for (const std::uint32_t size : {100u, 5 * chunk_of(options) + 7}) {
                INFO(to_string(shape) << ", radius " << radius << ", " << size);
                const MortonOrder order = random_order(size);
                const bool same = same_nodes(run_first_round(algorithm_of("ploc"), options, order),
                                             first_round_nodes(order, radius, Comparison::exact));
                CHECK(same);
            }
        }
    }
}

TEST_CASE("ploc: the tree and its rounds are the oracle's at sizes around chunks") {
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t radius : {1u, 16u}) {
            const BuildOptions options = small_chunks(shape, radius);
            for (const std::uint32_t size : sizes_around_chunks(chunk_of(options))) {
                INFO(to_string(shape) << ", radius " << radius << ", " << size);
                const MortonOrder order = random_order(size);
                const OracleTree expected = ploc_tree(order, radius, Comparison::exact);
                const ClusterResult result = run_cluster(algorithm_of("ploc"), options, order);
                CHECK(result.stats.clusters_per_iteration == expected.clusters_per_iteration);
                if (!expect_cluster_tree(result, expected)) return;
            }
        }
    }
}

TEST_CASE("ploc: distances are compared to the last bit") {
    const MortonOrder order = order_of_boxes(nearly_equal_boxes(700));
    const std::vector<Node> exact = first_round_nodes(order, 16, Comparison::exact);
    REQUIRE_FALSE(same_nodes(exact, first_round_nodes(order, 16, Comparison::packed)));
    for (const Shape shape : kBothShapes) {
        const bool same = same_nodes(run_first_round(algorithm_of("ploc"), options_of(shape), order), exact);
        CHECK(same);
    }
}

TEST_CASE("ploc: the search ends at the radius") {
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t radius : {1u, 7u, 31u}) {
            for (const std::uint32_t left : {0u, 40u, 200u}) {
                INFO(to_string(shape) << ", radius " << radius << ", position " << left);
                std::vector<Aabb> boxes = widening_points(300);
                const std::uint32_t right = left + radius + 1;
                boxes[right] = boxes[left];
                const MortonOrder order = order_of_boxes(boxes);
                const auto merges = [&](std::uint32_t search_radius) {
                    const BuildOptions options = small_chunks(shape, search_radius);
                    const Node node = run_first_round(algorithm_of("ploc"), options, order)[2 * right];
                    return node.count == 1 && node.first == left;
                };
                CHECK_FALSE(merges(radius));
                CHECK(merges(radius + 1));
            }
        }
    }
}

TEST_CASE("ploc: equal boxes halve in each round") {
    for (const Shape shape : kBothShapes) {
        const MortonOrder order = order_of_boxes(std::vector<Aabb>(1024, Aabb{{0, 0, 0}, {1, 1, 1}}));
        const ClusterResult result = run_cluster(algorithm_of("ploc"), small_chunks(shape, 16), order);
        CHECK(result.stats.clusters_per_iteration ==
              std::vector<std::uint32_t>{1024, 512, 256, 128, 64, 32, 16, 8, 4, 2});
        expect_cluster_tree(result, ploc_tree(order, 16, Comparison::exact));
    }
}

TEST_CASE("ploc: as many pieces as a large device takes") {
    const MortonOrder order = random_order(150000);
    const OracleTree expected = ploc_tree(order, 4, Comparison::exact);
    for (const Shape shape : kBothShapes) {
        BuildOptions options = small_chunks(shape, 4);
        options.ploc.work_group_size = 128;
        const ClusterResult result = run_cluster(algorithm_of("ploc"), large_device_settings(options), order);
        CHECK(result.stats.clusters_per_iteration == expected.clusters_per_iteration);
        expect_cluster_tree(result, expected);
    }
}
