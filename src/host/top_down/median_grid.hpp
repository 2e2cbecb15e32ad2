#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "clbvh/core/aabb.hpp"

namespace clbvh::host {

/// The planes that a scene's box is halved at again and again, along each axis by itself: those that a Morton code's
/// bits stand for. The middle has level 0, the middles of the halves level 1, and so on.
class MedianGrid {
public:
    static constexpr std::uint32_t kMostLevels = 20;

    explicit MedianGrid(const Aabb& scene) noexcept;

    struct Plane {
        std::size_t axis;
        std::uint32_t level;  ///< 0 to kMostLevels - 1.
        float position;
    };

    /// The plane of lowest level through the inside of `box`: on both sides of it there is something of the box. Where
    /// axes have planes of the same level, that along which the box is longest. Nothing where no plane is inside.
    [[nodiscard]] std::optional<Plane> most_important(const Aabb& box) const noexcept;

private:
    struct Axis {
        Axis(float begin, float end) noexcept;

        /// Plane 0 is the lower border, plane 2^levels the upper one. Each is at another place than the one before.
        [[nodiscard]] float plane(std::int64_t index) const noexcept {
            return static_cast<float>(lower + static_cast<double>(index) * cell);
        }
        [[nodiscard]] std::int64_t last_plane_up_to(float place) const noexcept;
        [[nodiscard]] std::int64_t last_plane_below(float place) const noexcept;

        double lower;
        double cell;           ///< Width of a cell of the finest level.
        std::uint32_t levels;  ///< 0 for an axis without extent.
    };

    std::array<Axis, 3> axes_;
};

}  // namespace clbvh::host
