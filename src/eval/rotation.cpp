#include "clbvh/eval/rotation.hpp"
#include "core/own_group.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

bool is_finite(const Vec3& v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::array<double, 3> unit_vector(const Vec3& axis) {
    const double length = std::hypot(double{axis.x}, double{axis.y}, double{axis.z});
    if (!is_finite(axis) || length == 0.0) {
        throw Error(ErrorCode::invalid_input,
                    "the axis of a rotation must be finite and not zero: give the direction to turn about");
    }
    return {axis.x / length, axis.y / length, axis.z / length};
}

}  // namespace

Rotation::Rotation(const Vec3& axis, double degrees) {
    const auto [x, y, z] = unit_vector(axis);
    if (!std::isfinite(degrees)) {
        throw Error(ErrorCode::invalid_input, "the angle of a rotation must be finite: give degrees");
    }
    // Whole turns are taken off while they are exact.
    const double angle = std::fmod(degrees, 360.0) * (std::numbers::pi / 180.0);
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    const double k = 1.0 - c;
    rows_ = {{{k * x * x + c, k * x * y - s * z, k * x * z + s * y},
              {k * x * y + s * z, k * y * y + c, k * y * z - s * x},
              {k * x * z - s * y, k * y * z + s * x, k * z * z + c}}};
}

Vec3 Rotation::operator()(const Vec3& v) const noexcept {
    if (!is_finite(v)) return v;
    const auto along = [&v](const std::array<double, 3>& row) {
        return static_cast<float>(row[0] * v.x + row[1] * v.y + row[2] * v.z);
    };
    return {along(rows_[0]), along(rows_[1]), along(rows_[2])};
}

Mesh rotated(Mesh mesh, const Rotation& rotation) {
    in_own_group([&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh.vertices.size(), 4096), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                mesh.vertices[i] = rotation(mesh.vertices[i]);
        });
    });
    return mesh;
}

}  // namespace clbvh
