#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clbvh/core/mesh.hpp"

namespace clbvh::test {

/// Boxes with a name for messages.
struct BoxSet {
    std::string name;
    std::vector<Aabb> boxes;
};

/// `count` small boxes of different sizes, spread evenly over a cube around the origin.
[[nodiscard]] std::vector<Aabb> random_boxes(std::size_t count, std::uint32_t seed = 1);

/// `count` boxes on a coarse grid, so that many centroids, sizes and distances are equal.
[[nodiscard]] std::vector<Aabb> grid_boxes(std::size_t count, std::uint32_t seed = 1);

/// Sets of `count` boxes each that are hard on builders: equal, concentric, flat, huge, tiny, far apart.
[[nodiscard]] std::vector<BoxSet> hard_box_sets(std::size_t count);

/// Triangle i has boxes[i] as its box.
[[nodiscard]] Mesh mesh_of_boxes(std::span<const Aabb> boxes);

}  // namespace clbvh::test
