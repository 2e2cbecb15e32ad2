#include "clbvh/eval/mesh_info.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/random.hpp"
#include "eval/double3.hpp"

namespace clbvh {
namespace {

using Corners = std::array<Vec3, 3>;
/// Half the length of the cross product of two edges, whose parts are scaled so that none overflows or vanishes.
double area_of(const Corners& corners) {
    Double3 a = difference(corners[1], corners[0]), b = difference(corners[2], corners[0]);
    double largest = 0.0;
    for (const Double3& edge : {a, b}) {
        for (const double part : edge)
            largest = std::max(largest, std::abs(part));
    }
    if (largest == 0.0) return 0.0;
    for (Double3* const edge : {&a, &b}) {
        for (double& part : *edge)
            part /= largest;
    }
    const Double3 normal = cross(a, b);
    return 0.5 * std::hypot(normal[0], normal[1], normal[2]) * largest * largest;
}

template <typename Predicate>
bool any_coordinate(const Corners& corners, const Predicate& predicate) {
    return std::ranges::any_of(
        corners, [&](const Vec3& corner) { return predicate(corner.x) || predicate(corner.y) || predicate(corner.z); });
}

/// The bits of the corners' coordinates, with one zero, in an order of their own.
using Key = std::array<std::uint32_t, 9>;

Key key_of(const Corners& corners) {
    std::array<std::array<std::uint32_t, 3>, 3> sorted{};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& corner = corners[i];
        sorted[i] = {std::bit_cast<std::uint32_t>(corner.x + 0.0f), std::bit_cast<std::uint32_t>(corner.y + 0.0f),
                     std::bit_cast<std::uint32_t>(corner.z + 0.0f)};
    }
    std::ranges::sort(sorted);
    return std::bit_cast<Key>(sorted);
}

std::uint64_t hash_of(const Key& key) {
    std::uint64_t hash = 0;
    for (const std::uint32_t word : key)
        hash = Random(hash ^ word).bits();
    return hash;
}

struct HashedTriangle {
    std::uint64_t hash;
    std::uint64_t triangle;
};

}  // namespace

MeshInfo mesh_info(const MeshView& mesh) {
    MeshInfo info;
    info.vertices = mesh.vertex_count;
    info.triangles = mesh.triangle_count;
    const auto corners_of = [&](std::uint64_t triangle) {
        const auto [a, b, c] = mesh.triangle(triangle);
        return Corners{mesh.vertex(a), mesh.vertex(b), mesh.vertex(c)};
    };
    std::vector<HashedTriangle> hashed;
    hashed.reserve(mesh.triangle_count);
    for (std::uint64_t i = 0; i < mesh.triangle_count; ++i) {
        for (const std::uint32_t index : mesh.triangle(i)) {
            if (index >= mesh.vertex_count)
                throw Error(ErrorCode::invalid_input, "triangle " + std::to_string(i) + ": vertex " +
                                                          std::to_string(index) + " does not exist; there are " +
                                                          std::to_string(mesh.vertex_count));
        }
        const Corners corners = corners_of(i);
        if (any_coordinate(corners, [](float value) { return std::abs(value) > kMaxCoordinate; })) {
            ++info.out_of_range;
        } else if (any_coordinate(corners, [](float value) { return std::isnan(value); })) {
            ++info.inactive;
        } else {
            const double area = area_of(corners);
            info.zero_area += area == 0.0 ? 1 : 0;
            info.area += area;
            info.bounds = merge(info.bounds, triangle_bounds(mesh, i));
            hashed.push_back({hash_of(key_of(corners)), i});
        }
    }
    std::ranges::sort(hashed, {}, &HashedTriangle::hash);
    // Of those with one hash, which are nearly always equal, each is compared with the one before it.
    for (std::size_t i = 1; i < hashed.size(); ++i) {
        if (hashed[i].hash == hashed[i - 1].hash &&
            key_of(corners_of(hashed[i].triangle)) == key_of(corners_of(hashed[i - 1].triangle)))
            ++info.duplicates;
    }
    return info;
}

}  // namespace clbvh
