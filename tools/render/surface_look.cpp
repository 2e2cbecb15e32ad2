#include "render/surface_look.hpp"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <clbvh/core/vector.hpp>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <tuple>

namespace clbvh::tool {
namespace {

constexpr float kFlatCosine = 0.82f;  // of the angle, some 35 degrees, up to which surfaces look round

constexpr std::array<Vec3, 9> kTints{{{0.73f, 0.71f, 0.67f},
                                      {0.62f, 0.34f, 0.25f},
                                      {0.42f, 0.52f, 0.38f},
                                      {0.30f, 0.43f, 0.55f},
                                      {0.70f, 0.60f, 0.44f},
                                      {0.60f, 0.42f, 0.42f},
                                      {0.68f, 0.50f, 0.22f},
                                      {0.36f, 0.36f, 0.38f},
                                      {0.50f, 0.46f, 0.58f}}};
constexpr Vec3 kFloor{0.46f, 0.35f, 0.26f};
constexpr std::uint8_t kPartWithFloor = 255;
constexpr double kLargeShare = 0.04;  // of the whole area
constexpr double kFloorShare = 0.15;  // of a part's area
constexpr float kLevelCosine = 0.9999f;

/// Bits, so that NaN has its place in the order as well.
auto order_of(const Vec3& v) {
    return std::tuple(std::bit_cast<std::uint32_t>(v.x), std::bit_cast<std::uint32_t>(v.y),
                      std::bit_cast<std::uint32_t>(v.z));
}

Vec3 doubled_area_normal(const Mesh& mesh, const Triangle& t) {
    return cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]);
}

/// Area of a part, and how much of it is level.
struct PartArea {
    double all = 0.0;
    double level = 0.0;
};

std::uint8_t tint_of(const PartArea& area, double whole, std::uint32_t part) {
    const std::uint32_t mixed = (part * 0x9E3779B9U) >> 16U;
    if (area.all <= kLargeShare * whole) return static_cast<std::uint8_t>(mixed % kTints.size());
    return area.level > kFloorShare * area.all ? kPartWithFloor : 0;
}

/// Sets that are joined two by two; each is known by one of its members.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0U); }

    [[nodiscard]] std::uint32_t find(std::uint32_t item) {
        while (parents_[item] != item) {
            parents_[item] = parents_[parents_[item]];
            item = parents_[item];
        }
        return item;
    }
    /// The smaller member stays, so that the order of joins does not show.
    void join(std::uint32_t a, std::uint32_t b) {
        const std::uint32_t root_a = find(a);
        const std::uint32_t root_b = find(b);
        parents_[std::max(root_a, root_b)] = std::min(root_a, root_b);
    }

private:
    std::vector<std::uint32_t> parents_;
};

}  // namespace

SurfaceLook::SurfaceLook(const Mesh& mesh, const Vec3& up) : mesh_(mesh), up_(up) {
    weld();
    smooth();
    tint();
}

void SurfaceLook::weld() {
    std::vector<std::uint32_t> order(mesh_.vertices.size());
    std::iota(order.begin(), order.end(), 0U);
    tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(order_of(mesh_.vertices[a]), a) < std::tuple(order_of(mesh_.vertices[b]), b);
    });
    welded_.resize(order.size());
    std::uint32_t first = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool is_new = i == 0 || order_of(mesh_.vertices[order[i]]) != order_of(mesh_.vertices[order[i - 1]]);
        if (is_new) first = order[i];
        welded_[order[i]] = first;
    }
}

void SurfaceLook::smooth() {
    normals_.resize(mesh_.vertices.size());
    for (const Triangle& triangle : mesh_.triangles) {
        const Vec3 normal = doubled_area_normal(mesh_, triangle);
        if (!std::isfinite(dot(normal, normal))) continue;
        for (const std::uint32_t index : triangle) {
            Vec3& sum = normals_[welded_[index]];
            sum = sum + normal;
        }
    }
    for (Vec3& normal : normals_)
        normal = normalized(normal);
}

void SurfaceLook::tint() {
    DisjointSets parts(mesh_.vertices.size());
    for (const Triangle& triangle : mesh_.triangles) {
        parts.join(welded_[triangle[0]], welded_[triangle[1]]);
        parts.join(welded_[triangle[0]], welded_[triangle[2]]);
    }
    std::vector<PartArea> areas(mesh_.vertices.size());
    double whole = 0.0;
    for (const Triangle& triangle : mesh_.triangles) {
        const Vec3 normal = doubled_area_normal(mesh_, triangle);
        const double area = length(normal);
        if (!std::isfinite(area)) continue;
        PartArea& part = areas[parts.find(welded_[triangle[0]])];
        part.all += area;
        if (std::abs(dot(normalized(normal), up_)) > kLevelCosine) part.level += area;
        whole += area;
    }
    tints_.resize(mesh_.vertices.size());
    for (std::uint32_t i = 0; i < tints_.size(); ++i) {
        const std::uint32_t part = parts.find(welded_[i]);
        tints_[i] = tint_of(areas[part], whole, part);
    }
}

Vec3 SurfaceLook::shading_normal(const Hit& hit, const Vec3& normal) const {
    const Triangle& triangle = mesh_.triangles[hit.primitive];
    const auto corner = [&](std::size_t i) {
        Vec3 smooth = normals_[welded_[triangle[i]]];
        if (dot(smooth, normal) < 0.0f) smooth = -smooth;
        return dot(smooth, normal) > kFlatCosine ? smooth : normal;
    };
    return normalized((corner(0) * (1.0f - hit.u - hit.v) + corner(1) * hit.u) + corner(2) * hit.v);
}

Vec3 SurfaceLook::albedo(const Hit& hit, const Vec3& normal) const {
    const std::uint8_t tint = tints_[welded_[mesh_.triangles[hit.primitive][0]]];
    if (tint != kPartWithFloor) return kTints[tint];
    return dot(normal, up_) > kLevelCosine ? kFloor : kTints[0];
}

}  // namespace clbvh::tool
