#pragma once

#include <clbvh/core/aabb.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clbvh::tool {

/// Colours of pixels, line by line from the top: red, green and blue in x, y and z.
class Picture {
public:
    Picture(std::uint32_t width, std::uint32_t height) : width_(width), pixels_(std::size_t{width} * height) {}

    [[nodiscard]] std::uint32_t width() const { return width_; }
    [[nodiscard]] std::uint32_t height() const { return static_cast<std::uint32_t>(pixels_.size() / width_); }
    [[nodiscard]] std::vector<Vec3>& pixels() { return pixels_; }
    [[nodiscard]] const std::vector<Vec3>& pixels() const { return pixels_; }
    [[nodiscard]] Vec3& at(std::uint32_t x, std::uint32_t y) { return pixels_[std::size_t{y} * width_ + x]; }

private:
    std::uint32_t width_;
    std::vector<Vec3> pixels_;
};

/// The pictures from left to right with a black line between them. All have the same height; there is at least one.
[[nodiscard]] Picture side_by_side(const std::vector<Picture>& pictures);

/// A pixel of light, without bounds, to what a screen shows, 0 to 1 in sRGB. `exposure` multiplies first; bright light
/// is pressed together, not cut off.
[[nodiscard]] Vec3 tone_mapped(const Vec3& light, float exposure);

/// The exposure of a picture of light, from those of its pixels that `counts` marks with 1, or all where it marks none:
/// their geometric mean becomes a middle grey.
[[nodiscard]] float fitting_exposure(const Picture& light, const std::vector<std::uint8_t>& counts);

/// The bytes of a PNG file of pixels that are 0 to 1 in sRGB, 8 bits a colour.
[[nodiscard]] std::string png_bytes(const Picture& picture);

}  // namespace clbvh::tool
