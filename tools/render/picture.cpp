#include "render/picture.hpp"

#include <algorithm>
#include <clbvh/core/error.hpp>
#include <cmath>

#include "render/colour.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#ifndef __clang_analyzer__  // what it says of other people's code is not for this project
#define STB_IMAGE_WRITE_IMPLEMENTATION
#endif
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace clbvh::tool {
namespace {

/// A smooth shoulder: 0 stays 0, large values come close to 1 (Hable's curve as fitted by Narkowicz, 2016).
float pressed(float x) {
    return std::clamp((x * (2.51f * x + 0.03f)) / (x * (2.43f * x + 0.59f) + 0.14f), 0.0f, 1.0f);
}

float to_srgb(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

unsigned char byte_of(float value) {
    return static_cast<unsigned char>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

void append(void* to, void* bytes, int count) {
    static_cast<std::string*>(to)->append(static_cast<const char*>(bytes), static_cast<std::size_t>(count));
}

}  // namespace

Picture side_by_side(const std::vector<Picture>& pictures) {
    constexpr std::uint32_t line_width = 4;
    std::uint32_t width = line_width * static_cast<std::uint32_t>(pictures.size() - 1);
    for (const Picture& picture : pictures)
        width += picture.width();
    Picture all(width, pictures.front().height());
    std::uint32_t left = 0;
    for (const Picture& picture : pictures) {
        for (std::size_t i = 0; i < picture.pixels().size(); ++i) {
            const auto x = static_cast<std::uint32_t>(i % picture.width());
            all.at(left + x, static_cast<std::uint32_t>(i / picture.width())) = picture.pixels()[i];
        }
        left += picture.width() + line_width;
    }
    return all;
}

Vec3 tone_mapped(const Vec3& light, float exposure) {
    const auto map = [exposure](float value) { return to_srgb(pressed(value * exposure)); };
    return {map(light.x), map(light.y), map(light.z)};
}

float fitting_exposure(const Picture& light, const std::vector<std::uint8_t>& counts) {
    constexpr double middle_grey = 0.26;
    const bool all = std::ranges::find(counts, std::uint8_t{1}) == counts.end();
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < light.pixels().size(); ++i) {
        if (!all && counts[i] == 0) continue;
        sum += std::log(1e-4 + static_cast<double>(brightness(light.pixels()[i])));
        count += 1.0;
    }
    return count > 0.0 ? static_cast<float>(middle_grey / std::exp(sum / count)) : 1.0f;
}

std::string png_bytes(const Picture& picture) {
    if (picture.pixels().empty()) throw Error(ErrorCode::invalid_input, "a picture without pixels has no PNG");
    std::vector<unsigned char> bytes;
    bytes.reserve(picture.pixels().size() * 3);
    for (const Vec3& pixel : picture.pixels())
        bytes.insert(bytes.end(), {byte_of(pixel.x), byte_of(pixel.y), byte_of(pixel.z)});
    std::string png;
    const int width = static_cast<int>(picture.width());
    const int height = static_cast<int>(picture.height());
    if (stbi_write_png_to_func(append, &png, width, height, 3, bytes.data(), width * 3) == 0)
        throw Error(ErrorCode::out_of_memory, "the picture's PNG does not fit into memory: make it smaller");
    return png;
}

}  // namespace clbvh::tool
