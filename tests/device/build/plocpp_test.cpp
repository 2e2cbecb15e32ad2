// What is special about PLOC++: pairs across the borders of chunks, two encodings, and one work group for the top.
#include <catch2/catch.hpp>

#include "device/build/cluster_bench.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Chunks so small that little input fills many, and a host that launches nearly all rounds.
BuildOptions small_chunks(Shape shape, std::uint32_t radius) {
    BuildOptions options = options_of(shape, radius);
    options.ploc.chunk_size = 64;
    options.ploc.work_group_size = 256;
    options.ploc.single_group_threshold = 2;
    return options;
}

std::uint32_t chunk_of(const BuildOptions& options) {
    const device::BuildSettings settings = settings_of(options);
    return settings.chunk_size(2 * settings.configs.ploc.search_radius);
}

Comparison comparison_of(NeighbourEncoding encoding) {
    return encoding == NeighbourEncoding::bits64 ? Comparison::exact : Comparison::packed;
}

/// Calls `check` with options of both shapes, encodings and, where the device can, searches.
template <typename Check>
void for_each_search(std::uint32_t radius, Check check) {
    const bool has_atomics = shared_context().device().int64_atomics;
    for (const Shape shape : kBothShapes) {
        for (const NeighbourEncoding encoding : {NeighbourEncoding::bits32, NeighbourEncoding::bits64}) {
            for (const NeighbourSearch search : {NeighbourSearch::scan, NeighbourSearch::symmetric}) {
                const bool symmetric = search == NeighbourSearch::symmetric;
                if (symmetric && (shape == Shape::lane || (encoding == NeighbourEncoding::bits64 && !has_atomics))) {
                    continue;
                }
                INFO(to_string(shape) << ", " << to_string(encoding) << ", " << to_string(search) << ", radius "
                                      << radius);
                BuildOptions options = small_chunks(shape, radius);
                options.ploc.neighbour_encoding = encoding;
                options.ploc.neighbour_search = search;
                check(options);
            }
        }
    }
}

}  // namespace

TEST_CASE("plocpp: the first round merges exactly the mutual pairs, in every search") {
    for (const std::uint32_t radius : {1u, 5u, 16u, 32u}) {
        for_each_search(radius, [&](const BuildOptions& options) {
            for (const std::uint32_t size : {100u, 5 * chunk_of(options) + 7}) {
                INFO(size);
                const MortonOrder order = random_order(size);
                const bool same =
                    same_nodes(run_first_round(algorithm_of("plocpp"), options, order),
                               first_round_nodes(order, radius, comparison_of(options.ploc.neighbour_encoding)));
                CHECK(same);
            }
        });
    }
}

TEST_CASE("plocpp: pairs across the border of two chunks merge once, at every distance") {
    for (const Shape shape : kBothShapes) {
        constexpr std::uint32_t radius = 16;
        const BuildOptions options = small_chunks(shape, radius);
        const std::uint32_t border = chunk_of(options);
        for (std::uint32_t distance = 1; distance <= radius; ++distance) {
            for (std::uint32_t left = border - distance; left < border; ++left) {
                INFO(to_string(shape) << ", " << left << " and " << left + distance << " around " << border);
                std::vector<Aabb> boxes = widening_points(2 * border + 5);
                boxes[left + distance] = boxes[left];
                const MortonOrder order = order_of_boxes(boxes);
                const std::vector<Node> nodes = run_first_round(algorithm_of("plocpp"), options, order);
                CHECK(nodes[2 * (left + distance)].first == left);
                CHECK(nodes[2 * (left + distance) + 1].first == left + distance);
                const bool same = same_nodes(nodes, first_round_nodes(order, radius, Comparison::packed));
                CHECK(same);
                if (!same) return;
            }
        }
    }
}

TEST_CASE("plocpp: the tree and its rounds are the oracle's at sizes around chunks") {
    for_each_search(16, [](const BuildOptions& options) {
        const std::uint32_t chunk = chunk_of(options);
        for (const std::uint32_t size : {1u, 2u, 3u, chunk - 1, chunk, chunk + 1, 2 * chunk, 40 * chunk + 1}) {
            INFO(size);
            const MortonOrder order = random_order(size);
            OracleTree expected = ploc_tree(order, 16, comparison_of(options.ploc.neighbour_encoding));
            const ClusterResult result = run_cluster(algorithm_of("plocpp"), options, order);
            std::erase(expected.clusters_per_iteration, 2u);  // the last work group's round
            CHECK(result.stats.clusters_per_iteration == expected.clusters_per_iteration);
            if (!expect_cluster_tree(result, expected)) return;
        }
    });
}

TEST_CASE("plocpp: one work group takes over at the threshold, not before") {
    for (const Shape shape : kBothShapes) {
        BuildOptions options = options_of(shape);
        options.ploc.single_group_threshold = 1000;
        for (const std::uint32_t size : {999u, 1000u, 1001u, 5000u}) {
            INFO(to_string(shape) << ", " << size);
            const MortonOrder order = random_order(size);
            OracleTree expected = ploc_tree(order, 16, Comparison::packed);
            const ClusterResult result = run_cluster(algorithm_of("plocpp"), options, order);
            std::erase_if(expected.clusters_per_iteration, [](std::uint32_t clusters) { return clusters <= 1000; });
            CHECK(result.stats.clusters_per_iteration == expected.clusters_per_iteration);
            expect_cluster_tree(result, expected);
        }
    }
}

TEST_CASE("plocpp: the tree is the same wherever the last work group takes over") {
    const MortonOrder order = random_order(3000);
    const OracleTree expected = ploc_tree(order, 16, Comparison::packed);
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t threshold : {2u, 3u, 50u, 960u, 961u, 2999u, 3000u}) {
            INFO(to_string(shape) << ", threshold " << threshold);
            BuildOptions options = options_of(shape);
            options.ploc.single_group_threshold = threshold;
            expect_cluster_tree(run_cluster(algorithm_of("plocpp"), options, order), expected);
        }
    }
}

TEST_CASE("plocpp: as many pieces as a large device takes") {
    const MortonOrder order = random_order(150000);
    const OracleTree expected = ploc_tree(order, 4, Comparison::packed);
    for (const Shape shape : kBothShapes) {
        BuildOptions options = small_chunks(shape, 4);
        options.ploc.work_group_size = 128;
        expect_cluster_tree(run_cluster(algorithm_of("plocpp"), large_device_settings(options), order), expected);
    }
}
