// The stage `root`: the root and the unused node beside it; every other node stands already.
#include "device/build/root.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr Node kChildren[2] = {{{-1, 2, -3}, 7, {4, 5, 6}, 1}, {{0, -2, -4}, 12, {3, 9, 5}, 0}};
constexpr Aabb kLeaf{{1, 2, 3}, {4, 5, 6}};

/// The nodes after launch_root, where every sibling pair but the first is kChildren.
std::vector<Node> run_layout(Shape shape, std::uint32_t leaf_count, std::uint32_t root_reference) {
    StageBench bench(options_of(shape), std::max(leaf_count, 1u));
    fill_bytes(bench.buffers.nodes, 0xff);
    std::vector<Node> nodes;
    for (std::uint32_t i = 0; i < 2 * leaf_count; ++i)
        nodes.push_back(kChildren[i % 2]);
    write(bench.buffers.nodes, nodes);
    write(bench.buffers.primitive_count, std::vector<std::uint32_t>{leaf_count});
    write(bench.buffers.leaves, std::vector<Aabb>(std::max(leaf_count, 1u), kLeaf));
    write(bench.buffers.root_reference, std::vector<std::uint32_t>{root_reference});
    device::launch_root(bench.launcher, bench.settings, bench.buffers, device::BoxOrder::morton);
    return read<Node>(bench.buffers.nodes, 2 * std::max(leaf_count, 1u));
}

}  // namespace

TEST_CASE("layout: the root of one leaf is that leaf") {
    for (const Shape shape : kBothShapes) {
        const std::vector<Node> nodes = run_layout(shape, 1, 0);
        CHECK(nodes[0] == Node{{1, 2, 3}, 0, {4, 5, 6}, 1});
        CHECK(nodes[1] == Node{});
    }
}

TEST_CASE("layout: the root of one leaf has the box of its primitive where boxes are not sorted") {
    const device::DeviceAlgorithm unsorted{nullptr,
                                           [](const device::BuildSettings&, std::uint32_t) { return std::uint64_t{0}; },
                                           device::BoxOrder::input, nullptr};
    for (const Shape shape : kBothShapes) {
        StageBench bench(settings_of(options_of(shape)), 3, &unsorted);
        write(bench.buffers.boxes, std::vector<Aabb>{{}, {}, kLeaf});
        write(bench.buffers.primitive_ids, std::vector<std::uint32_t>{2, 0, 1});
        write(bench.buffers.primitive_count, std::vector<std::uint32_t>{1});
        write(bench.buffers.root_reference, std::vector<std::uint32_t>{0});
        device::launch_root(bench.launcher, bench.settings, bench.buffers, device::BoxOrder::input);
        CHECK(read<Node>(bench.buffers.nodes, 1)[0] == Node{{1, 2, 3}, 0, {4, 5, 6}, 1});
    }
}

TEST_CASE("layout: the root of no leaves is a box that nothing hits") {
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (const Shape shape : kBothShapes) {
        const std::vector<Node> nodes = run_layout(shape, 0, 12345);
        CHECK(nodes[0] == Node{{inf, inf, inf}, 0, {-inf, -inf, -inf}, 0});
        CHECK(nodes[1] == Node{});
    }
}

TEST_CASE("layout: the root holds both its children, and the others stay") {
    constexpr std::uint32_t leaf_count = 300;
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t slot : {1u, 2u, 150u, 299u}) {
            INFO(to_string(shape) << ", slot " << slot);
            const std::vector<Node> nodes = run_layout(shape, leaf_count, leaf_count + slot);
            CHECK(nodes[0] == Node{{-1, -2, -4}, 2 * slot, {4, 9, 6}, 0});
            CHECK(nodes[1] == Node{});
            std::size_t kept = 2;
            while (kept < nodes.size() && nodes[kept] == kChildren[kept % 2])
                ++kept;
            CHECK(kept == nodes.size());
        }
    }
}

TEST_CASE("layout: the root of one leaf of several primitives has all of them and holds their boxes") {
    const auto no_bytes = [](const device::BuildSettings&, std::uint32_t) { return std::uint64_t{0}; };
    const device::DeviceAlgorithm unsorted{nullptr, no_bytes, device::BoxOrder::input, nullptr};
    for (const Shape shape : kBothShapes) {
        BuildOptions options = options_of(shape);
        options.hploc.leaf_size = 4;
        StageBench bench(settings_of(options), 3, &unsorted);
        write(bench.buffers.boxes, std::vector<Aabb>{{{9, 9, 9}, {9, 9, 9}}, {{-1, 3, 4}, {1, 8, 5}}, kLeaf});
        write(bench.buffers.primitive_ids, std::vector<std::uint32_t>{2, 1, 0});
        write(bench.buffers.primitive_count, std::vector<std::uint32_t>{2});
        write(bench.buffers.leaf_count, std::vector<std::uint32_t>{1});
        write(bench.buffers.root_reference, std::vector<std::uint32_t>{0});
        device::launch_root(bench.launcher, bench.settings, bench.buffers, device::BoxOrder::input);
        CHECK(read<Node>(bench.buffers.nodes, 2) == std::vector<Node>{{{-1, 2, 3}, 0, {4, 8, 6}, 2}, {}});
    }
}

TEST_CASE("layout: nodes behind the leaves' own become zero, and those behind the primitives' stay") {
    for (const Shape shape : kBothShapes) {
        BuildOptions options = options_of(shape);
        options.hploc.leaf_size = 4;
        for (const std::uint32_t leaf_count : {0u, 1u, 700u, 2000u}) {
            INFO(to_string(shape) << ", " << leaf_count);
            StageBench bench(settings_of(options), 2100);
            fill_bytes(bench.buffers.nodes, 0xff);
            write(bench.buffers.primitive_count, std::vector<std::uint32_t>{2000});
            write(bench.buffers.leaf_count, std::vector{leaf_count});
            device::launch_clear_unused(bench.launcher, bench.settings, bench.buffers);
            const std::vector<Node> nodes = read<Node>(bench.buffers.nodes, 4200);
            const auto is_zero = [](const Node& node) { return node == Node{}; };
            const auto first = std::find_if(nodes.begin(), nodes.end(), is_zero);
            CHECK(first - nodes.begin() == (leaf_count == 2000 ? 4200 : 2 * leaf_count));
            CHECK(std::count_if(nodes.begin(), nodes.end(), is_zero) == 2 * (2000 - leaf_count));
        }
    }
}
