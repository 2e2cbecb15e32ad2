// The first clusters: boxes gathered in Morton order, and their numbers.
#include "device/build/leaves.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const std::vector<std::size_t> kSizes{1, 2, 15, 16, 17, 255, 256, 257, 1023, 1024, 1025, 4097, 30001};
constexpr std::size_t kBehind = 100;  // values beyond the last leaf that must stay

/// Numbers of leaves, each with launches sized for it and for more.
std::vector<std::pair<std::size_t, std::size_t>> sizes_and_launches() {
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (const std::size_t leaf_count : kSizes) {
        pairs.emplace_back(leaf_count, leaf_count);
        pairs.emplace_back(leaf_count, leaf_count + kBehind);
    }
    return pairs;
}

std::vector<std::uint32_t> shuffled_ids(std::size_t count) {
    std::vector<std::uint32_t> ids(count);
    std::iota(ids.begin(), ids.end(), 0u);
    std::shuffle(ids.begin(), ids.end(), std::mt19937(9));
    return ids;
}

std::vector<Aabb> boxes_of(const Mesh& mesh) {
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(triangle_bounds(mesh, i));
    return boxes;
}

}  // namespace

TEST_CASE("leaves: boxes follow the order of the primitives, and two zeros behind the last leaf") {
    for (const Shape shape : kBothShapes) {
        for (const auto& [leaf_count, sized_for] : sizes_and_launches()) {
            INFO(to_string(shape) << ", " << leaf_count << " of " << sized_for);
            const std::size_t primitives = leaf_count + kBehind;
            const std::vector<Aabb> boxes = boxes_of(random_triangles(primitives));
            const std::vector<std::uint32_t> ids = shuffled_ids(primitives);
            const Aabb untouched{{1, 2, 3}, {4, 5, 6}};
            StageBench bench(options_of(shape), primitives);
            write(bench.buffers.boxes, boxes);
            write(bench.buffers.primitive_ids, ids);
            write(bench.buffers.leaf_count, std::vector{static_cast<std::uint32_t>(leaf_count)});
            write(bench.buffers.leaves, std::vector<Aabb>(primitives, untouched));

            device::launch_leaves(bench.launcher, bench.settings, bench.buffers, static_cast<std::uint32_t>(sized_for));

            std::vector<Aabb> expected(primitives, untouched);
            for (std::size_t i = 0; i < leaf_count; ++i)
                expected[i] = boxes[ids[i]];
            expected[leaf_count].lower = {0, 0, 3};
            const bool same_boxes = read<Aabb>(bench.buffers.leaves, primitives) == expected;
            CHECK(same_boxes);
        }
    }
}

TEST_CASE("leaves: cluster i is leaf i, and nothing is written behind the last") {
    for (const Shape shape : kBothShapes) {
        for (const auto& [leaf_count, sized_for] : sizes_and_launches()) {
            INFO(to_string(shape) << ", " << leaf_count << " of " << sized_for);
            StageBench bench(options_of(shape), leaf_count + kBehind);
            fill_bytes(bench.buffers.references_a, 0xff);

            write(bench.buffers.leaf_count, std::vector{static_cast<std::uint32_t>(leaf_count)});
            device::launch_number_leaves(bench.launcher, bench.settings, bench.buffers,
                                         static_cast<std::uint32_t>(sized_for));

            std::vector<std::uint32_t> expected(leaf_count + kBehind, 0xffffffff);
            std::iota(expected.begin(), expected.begin() + static_cast<std::ptrdiff_t>(leaf_count), 0u);
            const bool same_numbers = read<std::uint32_t>(bench.buffers.references_a, expected.size()) == expected;
            CHECK(same_numbers);
        }
    }
}
