#include "device/build/cluster_bench.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <numeric>
#include <optional>

#include "clbvh/core/error.hpp"
#include "device/build/stage_bench.hpp"
#include "support/meshes.hpp"

namespace clbvh::test {
namespace {

/// Puts the leaves and codes of `order` in place, with no node written.
void prepare(StageBench& bench, const MortonOrder& order) {
    fill_bytes(bench.buffers.nodes, 0xff);
    write(bench.buffers.codes, order.codes);
    if (bench.buffers.leaves() != nullptr) {
        write(bench.buffers.leaves, order.bounds);
        return;
    }
    std::vector<std::uint32_t> ids(order.bounds.size());
    std::iota(ids.begin(), ids.end(), 0u);
    write(bench.buffers.primitive_ids, ids);
    write(bench.buffers.boxes, order.bounds);
}

void cluster(StageBench& bench, const device::DeviceAlgorithm& algorithm, std::size_t leaf_count) {
    algorithm.cluster({bench.launcher, bench.settings, bench.buffers, static_cast<std::uint32_t>(leaf_count)});
}

/// What the smallest of decides the neighbour of i.
std::pair<std::uint32_t, std::uint32_t> key_of(const MortonOrder& order, std::size_t i, std::size_t j,
                                               std::uint32_t radius, Comparison comparison) {
    const auto distance = std::bit_cast<std::uint32_t>(half_area(merge(order.bounds[i], order.bounds[j])));
    const auto offset = static_cast<std::uint32_t>(i ^ j);
    if (comparison == Comparison::exact) return {distance, offset};
    std::uint32_t mask = 1;
    while (mask < 2 * radius + 1)
        mask *= 2;
    --mask;
    return {((distance << 1) & ~mask) | (offset & mask), 0};
}

std::optional<std::size_t> nearest(const MortonOrder& order, std::size_t i, std::uint32_t radius,
                                   Comparison comparison) {
    std::optional<std::size_t> best;
    for (std::size_t j = i - std::min<std::size_t>(i, radius); j < order.bounds.size() && j <= i + radius; ++j) {
        if (j == i) continue;
        if (!best || key_of(order, i, j, radius, comparison) < key_of(order, i, *best, radius, comparison)) best = j;
    }
    return best;
}

Node leaf_node(const MortonOrder& order, std::size_t i) {
    const Aabb& box = order.bounds[i];
    return {{box.lower.x, box.lower.y, box.lower.z},
            static_cast<std::uint32_t>(i),
            {box.upper.x, box.upper.y, box.upper.z},
            1};
}

}  // namespace

ClusterResult run_cluster(const device::DeviceAlgorithm& algorithm, const BuildOptions& options,
                          const MortonOrder& order) {
    return run_cluster(algorithm, settings_of(options), order);
}

ClusterResult run_cluster(const device::DeviceAlgorithm& algorithm, const device::BuildSettings& settings,
                          const MortonOrder& order) {
    StageBench bench(settings, order.bounds.size(), &algorithm);
    prepare(bench, order);
    cluster(bench, algorithm, order.bounds.size());
    ClusterResult result;
    result.nodes = read<Node>(bench.buffers.nodes, 2 * order.bounds.size());
    result.root_reference = bench.launcher.read_uint(bench.buffers.root_reference);
    result.stats = bench.launcher.finish();
    return result;
}

std::vector<Node> run_first_round(const device::DeviceAlgorithm& algorithm, BuildOptions options,
                                  const MortonOrder& order) {
    std::size_t rounds = 0;
    options.ploc.single_group_threshold = 2;
    device::BuildSettings settings = settings_of(options);
    settings.iterations_in_flight = 1;
    StageBench bench(settings, order.bounds.size(), &algorithm,
                     [&](const Progress& progress) { return progress.fraction == 0.0 || ++rounds < 2; });
    prepare(bench, order);
    CHECK_THROWS_AS(cluster(bench, algorithm, order.bounds.size()), Error);
    CHECK(rounds == 2);
    return read<Node>(bench.buffers.nodes, 2 * order.bounds.size());
}

std::vector<Node> first_round_nodes(const MortonOrder& order, std::uint32_t radius, Comparison comparison) {
    std::vector<Node> nodes(2 * order.bounds.size());
    std::memset(nodes.data(), 0xff, nodes.size() * sizeof(Node));
    for (std::size_t i = 0; i < order.bounds.size(); ++i) {
        const std::optional<std::size_t> j = nearest(order, i, radius, comparison);
        if (!j || *j < i || nearest(order, *j, radius, comparison) != i) continue;
        nodes[2 * *j] = leaf_node(order, i);
        nodes[2 * *j + 1] = leaf_node(order, *j);
    }
    return nodes;
}

bool same_nodes(const std::vector<Node>& a, const std::vector<Node>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Node)) == 0;
}

bool expect_cluster_tree(const ClusterResult& result, const OracleTree& expected) {
    const std::vector<Node>& nodes = expected.bvh.nodes;
    const std::size_t leaf_count = nodes.size() / 2;
    const bool root_is_leaf = nodes[0].is_leaf();
    const std::size_t root = root_is_leaf ? nodes[0].first : leaf_count + nodes[0].first / 2;
    std::size_t same = 2;  // the root and the node beside it are another stage's
    while (same < nodes.size() && std::memcmp(&nodes[same], &result.nodes[same], sizeof(Node)) == 0)
        ++same;
    CHECK(same == nodes.size());
    CHECK(result.root_reference == root);
    return same == nodes.size() && result.root_reference == root;
}

MortonOrder random_order(std::size_t count) {
    return morton_order(random_triangles(count), MortonCode::xyz);
}

MortonOrder order_of_boxes(std::vector<Aabb> boxes) {
    MortonOrder order;
    order.primitive_count = boxes.size();
    order.codes.resize(boxes.size());
    order.ids.resize(boxes.size());
    std::iota(order.ids.begin(), order.ids.end(), 0u);
    order.bounds = std::move(boxes);
    return order;
}

std::vector<Aabb> widening_points(std::size_t count) {
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < count; ++i) {
        const auto step = static_cast<float>(i);
        const Vec3 point{step * step, step * step, 0};
        boxes.push_back({point, point});
    }
    return boxes;
}

}  // namespace clbvh::test
