#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "clbvh/core/bvh.hpp"
#include "clbvh/layout/compressed8.hpp"
#include "core/simd/float4.hpp"
#include "layout/quantized_boxes.hpp"

namespace clbvh::layout {

/// The bounds of eight nodes' boxes, axis by axis.
inline void gather_bounds(const std::array<const Node*, 8>& nodes, std::array<AxisBounds, 3>& bounds) noexcept {
    const auto gather_side = [&](std::size_t begin, auto corner_of, auto side) {
        Float4 a = Float4::load(corner_of(*nodes[begin])), b = Float4::load(corner_of(*nodes[begin + 1]));
        Float4 c = Float4::load(corner_of(*nodes[begin + 2])), d = Float4::load(corner_of(*nodes[begin + 3]));
        Float4::transpose(a, b, c, d);
        a.store((bounds[0].*side).data() + begin);
        b.store((bounds[1].*side).data() + begin);
        c.store((bounds[2].*side).data() + begin);
    };
    for (const std::size_t begin : {std::size_t{0}, std::size_t{4}}) {
        gather_side(
            begin, [](const Node& node) { return node.lower; }, &AxisBounds::lower);
        gather_side(
            begin, [](const Node& node) { return node.upper; }, &AxisBounds::upper);
    }
}

/// Writes a node's grid, and on it the box of what is in each slot: the box of boxes[slot]. Slots whose pointer is null
/// get zeros; one at least is not.
inline void write_grid(const std::array<const Node*, 8>& boxes, Compressed8Node& node) noexcept {
    std::size_t some = 0;  // a box that stands in for those that are not there
    while (boxes[some] == nullptr)
        ++some;
    std::array<const Node*, 8> sources;
    std::array<std::uint8_t, 8> masks;
    for (std::size_t slot = 0; slot < 8; ++slot) {
        sources[slot] = boxes[slot] == nullptr ? boxes[some] : boxes[slot];
        masks[slot] = static_cast<std::uint8_t>(boxes[slot] == nullptr ? 0 : 0xFF);
    }
    std::array<AxisBounds, 3> bounds;
    gather_bounds(sources, bounds);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const QuantizedAxis quantized = quantize(bounds[axis]);
        node.origin[axis] = quantized.origin;
        node.exponent[axis] = quantized.exponent;
        for (std::size_t slot = 0; slot < 8; ++slot) {
            node.lower[axis][slot] = quantized.lower[slot] & masks[slot];
            node.upper[axis][slot] = quantized.upper[slot] & masks[slot];
        }
    }
}

}  // namespace clbvh::layout
