#pragma once

#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/layout/wide.hpp"

namespace clbvh::test {

/// The closest hit, found by traversals as plain as possible over the bytes of a layout, as the layouts' tables have
/// them. The layout is one over the mesh; its links are followed wherever they lead.
[[nodiscard]] Hit closest_in(const SkipLayout& layout, const Mesh& mesh, const Ray& ray);
[[nodiscard]] Hit closest_in(const PairLayout& layout, const Mesh& mesh, const Ray& ray);
[[nodiscard]] Hit closest_in(const Compressed8& layout, const Mesh& mesh, const Ray& ray);
[[nodiscard]] Hit closest_in(const Wide8& layout, const Mesh& mesh, const Ray& ray);
[[nodiscard]] Hit closest_in(const Wide4& layout, const Mesh& mesh, const Ray& ray);

/// How many nodes that search visits, and how many where it visits the slots of each node from the last to the first
/// of its octant's order.
struct OrderCosts {
    std::size_t in_order = 0, backwards = 0;
};
[[nodiscard]] OrderCosts order_costs(const Compressed8& layout, const Mesh& mesh, const Ray& ray);

}  // namespace clbvh::test
