#include "embree/split_triangle.hpp"

#include <array>
#include <cstddef>
#include <limits>

namespace clbvh::tool {
namespace {

using Corners = std::array<Lanes, 3>;

Lanes smaller(Lanes a, Lanes b) {
    return a < b ? a : b;
}

Lanes larger(Lanes a, Lanes b) {
    return a > b ? a : b;
}

Lanes lanes_of(const Vec3& v) {
    return Lanes{v.x, v.y, v.z, 0.0f};
}

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr LaneBox kEmpty{{kInfinity, kInfinity, kInfinity, kInfinity},
                         {-kInfinity, -kInfinity, -kInfinity, -kInfinity}};

void add(LaneBox& box, Lanes low, Lanes high) {
    box.lower = smaller(box.lower, low);
    box.upper = larger(box.upper, high);
}

LaneBox intersection(const LaneBox& a, const LaneBox& b) {
    return {larger(a.lower, b.lower), smaller(a.upper, b.upper)};
}

/// Adds the point where the edge `from` .. `to` meets the plane to both boxes.
template <unsigned Axis>
void add_crossing(Lanes from, Lanes to, float position, SplitBounds& split) {
    const Lanes point = from + (to - from) * ((position - from[Axis]) / (to[Axis] - from[Axis]));
    // `point` is off by at most 7 rounding errors of 2^-24 (|from| + |to|).
    const Lanes magnitude = larger(from, -from) + larger(to, -to);
    const Lanes slack = magnitude * 0x1p-21f + std::numeric_limits<float>::min();
    Lanes low = point - slack;
    Lanes high = point + slack;
    low[Axis] = position;
    high[Axis] = position;
    add(split.left, low, high);
    add(split.right, low, high);
}

template <unsigned Axis>
SplitBounds split_at(const Corners& corners, const LaneBox& box, float position) {
    SplitBounds split{kEmpty, kEmpty};
    for (std::size_t i = 0; i < 3; ++i) {
        const Lanes from = corners[i];
        const Lanes to = corners[i == 2 ? 0 : i + 1];
        const float begin = from[Axis];
        const float end = to[Axis];
        if (begin <= position) add(split.left, from, from);
        if (begin >= position) add(split.right, from, from);
        if ((begin < position && position < end) || (end < position && position < begin))
            add_crossing<Axis>(from, to, position, split);
    }
    return {intersection(split.left, box), intersection(split.right, box)};
}

}  // namespace

SplitBounds split_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const LaneBox& box, unsigned axis,
                           float position) {
    const Corners corners{lanes_of(a), lanes_of(b), lanes_of(c)};
    // A lane that is known when compiled is a shuffle; another one is a detour through memory.
    switch (axis) {
        case 0: return split_at<0>(corners, box, position);
        case 1: return split_at<1>(corners, box, position);
        default: return split_at<2>(corners, box, position);
    }
}

}  // namespace clbvh::tool
