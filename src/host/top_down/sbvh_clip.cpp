#include "host/top_down/sbvh_clip.hpp"

#include <limits>

namespace clbvh::host {
namespace {

Float4 load(const Vec3& v) noexcept {
    return Float4::of(v.x, v.y, v.z);
}

Float4 magnitude(Float4 a) noexcept {
    return max(a, Float4::filled(0.0f) - a);
}

}  // namespace

CutTriangle::CutTriangle(const MeshView& mesh, std::uint32_t triangle) noexcept {
    const Triangle indices = mesh.triangle(triangle);
    for (std::size_t i = 0; i < 3; ++i) {
        corners_[i] = load(mesh.vertex(indices[i]));
        corners_[i].store(coordinates_[i].data());
    }
}

Box4 CutTriangle::bound_crossing(std::size_t from, std::size_t to, std::size_t axis, float plane) const noexcept {
    // With u = 2^-24: two differences and a quotient give t within 3 u of itself, the edge's length and the product
    // with it 2 u more; adding the start rounds by u of the result, and so does growing. Below the smallest normal
    // number each step is off by a unit of the denormal ones at most.
    const float start = coordinates_[from][axis];
    const float t = (plane - start) / (coordinates_[to][axis] - start);
    const Float4 along = corners_[to] - corners_[from];
    const Float4 point = corners_[from] + Float4::filled(t) * along;
    const Float4 edge = magnitude(along);
    const Float4 largest = max(magnitude(corners_[from]), magnitude(corners_[to]));
    const Float4 error = max(edge * Float4::filled(0x1p-21f) + largest * Float4::filled(0x1p-22f),
                             Float4::filled(32 * std::numeric_limits<float>::denorm_min()));
    return {point - error, point + error};
}

Box4 CutTriangle::bound_between(std::size_t axis, float lower, float upper) const noexcept {
    Box4 box;
    for (std::size_t from = 0; from < 3; ++from) {
        const std::size_t to = (from + 1) % 3;
        const float start = coordinates_[from][axis];
        const float end = coordinates_[to][axis];
        if (lower <= start && start <= upper) box.merge(corners_[from]);
        for (const float plane : {lower, upper}) {
            if ((start < plane && plane < end) || (end < plane && plane < start)) {
                box.merge(bound_crossing(from, to, axis, plane));
            }
        }
    }
    return box;
}

Box4 with_range(const Box4& box, std::size_t axis, float lower, float upper) noexcept {
    std::array<float, 4> low, high;
    box.lower.store(low.data());
    box.upper.store(high.data());
    low[axis] = lower;
    high[axis] = upper;
    return {Float4::load(low.data()), Float4::load(high.data())};
}

CutReference cut_reference(const MeshView* mesh, const Reference& reference, std::size_t axis, float plane) noexcept {
    const Box4 box = Box4::of(reference);
    const std::array<float, 3> borders{reference.lower[axis], plane, reference.upper[axis]};
    std::array<Box4, 2> parts{box, box};
    if (mesh != nullptr) {
        const CutTriangle triangle(*mesh, reference.primitive);
        for (std::size_t i = 0; i < 2; ++i)
            parts[i] = intersect(box, triangle.bound_between(axis, borders[i], borders[i + 1]));
    }
    for (std::size_t i = 0; i < 2; ++i) {
        parts[i] = intersect(parts[i], with_range(parts[i], axis, borders[i], borders[i + 1]));
        parts[i] = without_negative_zeros(parts[i]);
    }
    return {parts[0], parts[1]};
}

}  // namespace clbvh::host
