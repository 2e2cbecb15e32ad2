// The object median: its halves are what sorting gives, and its depth is the least there is.
#include "clbvh/host/median.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"
#include "support/references.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// The ids below a node.
void collect(const Bvh& bvh, std::uint32_t index, std::vector<std::uint32_t>& ids) {
    const Node& node = bvh.nodes[index];
    if (node.is_leaf()) {
        ids.insert(ids.end(), bvh.primitive_ids.begin() + node.first,
                   bvh.primitive_ids.begin() + node.first + node.count);
        return;
    }
    collect(bvh, node.first, ids);
    collect(bvh, node.first + 1, ids);
}

std::array<float, 3> doubled(const Aabb& box) {
    const Vec3 c = doubled_centroid(box);
    return {c.x, c.y, c.z};
}

/// The left half of `ids` in the order of their centroids along the longest axis.
std::vector<std::uint32_t> expected_left(std::vector<std::uint32_t> ids, const std::vector<Aabb>& boxes) {
    std::array<float, 3> lower, upper;
    lower.fill(std::numeric_limits<float>::infinity());
    upper.fill(-std::numeric_limits<float>::infinity());
    for (const std::uint32_t id : ids) {
        for (std::size_t a = 0; a < 3; ++a) {
            lower[a] = std::min(lower[a], doubled(boxes[id])[a]);
            upper[a] = std::max(upper[a], doubled(boxes[id])[a]);
        }
    }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a) {
        if (upper[a] - lower[a] > upper[axis] - lower[axis]) axis = a;
    }
    std::ranges::sort(ids, [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(doubled(boxes[a])[axis], a) < std::pair(doubled(boxes[b])[axis], b);
    });
    ids.resize(ids.size() / 2);
    std::ranges::sort(ids);
    return ids;
}

}  // namespace

TEST_CASE("median: every inner node halves its primitives where sorting would") {
    for (const std::string_view scene : {"soup", "city", "particles", "line"}) {
        const Mesh mesh = generate_scene(scene, 700);
        const std::vector<Aabb> boxes = boxes_of(mesh);
        const Bvh bvh = build_median(boxes, {1});
        REQUIRE(validate(bvh, mesh).error == "");
        for (std::uint32_t i = 0; i < bvh.nodes.size(); ++i) {
            if (i == 1 || bvh.nodes[i].is_leaf()) continue;
            std::vector<std::uint32_t> all, left;
            collect(bvh, i, all);
            collect(bvh, bvh.nodes[i].first, left);
            std::ranges::sort(left);
            REQUIRE(left == expected_left(all, boxes));
        }
    }
}

TEST_CASE("median: leaves are as full as allowed, and the tree is as flat as can be") {
    for (const std::uint32_t size : {1u, 8u, 9u, 1000u, 4096u, 30000u}) {
        const Mesh mesh = generate_scene("soup", size);
        for (const std::uint32_t leaf : {1u, 8u, 64u}) {
            const ValidationReport report = validate(build_median(boxes_of(mesh), {leaf}), mesh);
            CHECK(report.error == "");
            CHECK(report.depth == std::bit_width((size - 1) / leaf));
        }
    }
}

TEST_CASE("median names what is wrong with its input") {
    expect_error(ErrorCode::invalid_input, {"max_leaf_size is 65", "1 to 64"},
                 [] { static_cast<void>(build_median({}, {65})); });
    const std::vector<Aabb> boxes{{{0, 0, 0}, {std::numeric_limits<float>::infinity(), 1, 1}}};
    expect_error(ErrorCode::invalid_input, {"box 0"}, [&] { static_cast<void>(build_median(boxes)); });
}
