#include "render/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

#include "render/colour_map.hpp"

namespace clbvh::tool {
namespace {

constexpr Vec3 kInk{1.0f, 1.0f, 1.0f};
constexpr Vec3 kPaper{0.08f, 0.08f, 0.08f};

/// Five lines of three dots, the top line first; the highest bit of a line is its left dot.
struct Glyph {
    char character;
    std::array<std::uint8_t, 5> lines;
};
constexpr std::array<Glyph, 11> kGlyphs{{{'0', {7, 5, 5, 5, 7}},
                                         {'1', {2, 6, 2, 2, 7}},
                                         {'2', {7, 1, 7, 4, 7}},
                                         {'3', {7, 1, 3, 1, 7}},
                                         {'4', {5, 5, 7, 1, 1}},
                                         {'5', {7, 4, 7, 1, 7}},
                                         {'6', {7, 4, 7, 5, 7}},
                                         {'7', {7, 1, 2, 2, 2}},
                                         {'8', {7, 5, 7, 5, 7}},
                                         {'9', {7, 5, 7, 1, 7}},
                                         {'.', {0, 0, 0, 0, 2}}}};
constexpr std::uint32_t kGlyphWidth = 3;
constexpr std::uint32_t kGlyphHeight = 5;

std::uint32_t text_width(std::string_view text, std::uint32_t dot) {
    return static_cast<std::uint32_t>(text.size()) * (kGlyphWidth + 1) * dot - dot;
}

void fill(Picture& picture, std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height,
          const Vec3& colour) {
    for (std::uint32_t line = y; line < std::min(y + height, picture.height()); ++line) {
        for (std::uint32_t column = x; column < std::min(x + width, picture.width()); ++column)
            picture.at(column, line) = colour;
    }
}

/// Draws with dots of so many pixels; (x, y) is the upper left corner.
void draw_text(Picture& picture, std::string_view text, std::uint32_t x, std::uint32_t y, std::uint32_t dot) {
    for (const char character : text) {
        const auto glyph = std::ranges::find(kGlyphs, character, &Glyph::character);
        for (std::uint32_t i = 0; glyph != kGlyphs.end() && i < kGlyphWidth * kGlyphHeight; ++i) {
            const std::uint32_t column = i % kGlyphWidth;
            const std::uint32_t line = i / kGlyphWidth;
            if ((glyph->lines[line] >> (kGlyphWidth - 1 - column) & 1U) == 0) continue;
            fill(picture, x + column * dot, y + line * dot, dot, dot, kInk);
        }
        x += (kGlyphWidth + 1) * dot;
    }
}

/// The colours from 0 to `end` along the lower edge, with five numbers above.
void draw_legend(Picture& picture, float end) {
    const std::uint32_t dot = std::max(1U, picture.height() / 180);
    const std::uint32_t margin = 4 * dot;
    const std::uint32_t bar_height = 6 * dot;
    const std::uint32_t box_height = kGlyphHeight * dot + bar_height + 2 * margin + 2 * dot;
    if (picture.height() < 2 * box_height || picture.width() < 60 * dot) return;
    const std::uint32_t top = picture.height() - box_height;
    const std::uint32_t left = 4 * margin;
    const std::uint32_t bar_width = picture.width() - 2 * left;
    fill(picture, 0, top, picture.width(), box_height, kPaper);
    for (std::uint32_t column = 0; column < bar_width; ++column) {
        const float value = static_cast<float>(column) / static_cast<float>(bar_width - 1);
        fill(picture, left + column, picture.height() - margin - bar_height, 1, bar_height, heat_colour(value));
    }
    for (std::uint32_t tick = 0; tick <= 4; ++tick) {
        const float value = end * static_cast<float>(tick) / 4.0f;
        const std::string text = end < 10.0f ? fmt::format("{:.1f}", value) : fmt::format("{:.0f}", value);
        const std::uint32_t middle = left + (bar_width - 1) * tick / 4;
        draw_text(picture, text, middle - std::min(middle, text_width(text, dot) / 2), top + margin, dot);
    }
}

}  // namespace

float fitting_scale_end(std::vector<float> values) {
    if (values.empty()) return 1.0f;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(values.size() - 1) * 0.99);
    std::ranges::nth_element(values, at);
    return std::max(1.0f, std::ceil(*at));
}

Picture heat_map(const std::vector<float>& values, std::uint32_t width, std::uint32_t height, float scale_end) {
    Picture picture(width, height);
    std::ranges::transform(values, picture.pixels().begin(),
                           [&](float value) { return heat_colour(value / scale_end); });
    draw_legend(picture, scale_end);
    return picture;
}

}  // namespace clbvh::tool
