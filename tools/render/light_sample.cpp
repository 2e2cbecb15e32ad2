#include "render/light_sample.hpp"

#include <algorithm>
#include <clbvh/core/vector.hpp>
#include <clbvh/eval/surface.hpp>
#include <cmath>
#include <cstddef>

namespace clbvh::tool {
namespace {

constexpr float kNearestLamp = 4.0f;  // in radii: nearer surfaces get no more light than there

float square(float value) {
    return value * value;
}

/// About how much of a light a surface can expect. Lamps come first, then the sun.
float expected_light(const Lighting& lighting, std::size_t index, const Vec3& position, const Vec3& normal) {
    if (index == lighting.lamps.size())
        return lighting.sunny_share * kSunlight.y * std::max(0.0f, dot(normal, *lighting.to_sun));
    const Lamp& lamp = lighting.lamps[index];
    const Vec3 way = lamp.centre - position;
    const float distance = length(way);
    // A ball is seen somewhat beyond the horizon of its centre.
    const float cosine = dot(normal, normalized(way)) + lamp.radius / std::max(distance, lamp.radius);
    return lamp.intensity * std::max(0.0f, cosine) / square(std::max(distance, kNearestLamp * lamp.radius));
}

/// (x, y) is a place in the unit disc.
LightSample sunlight(const Vec3& to_sun, float x, float y) {
    const Vec3 above = cosine_direction(to_sun, x, y);
    const Vec3 in_disc = above - to_sun * dot(above, to_sun);
    return {normalized(to_sun + in_disc * kSunRadius), std::numeric_limits<float>::infinity(), kSunlight};
}

/// (x, y) is a place in the disc that the lamp shows.
LightSample lamplight(const Lamp& lamp, const Vec3& position, float x, float y) {
    const Vec3 back = normalized(position - lamp.centre);
    const Vec3 way = lamp.centre + cosine_direction(back, x, y) * lamp.radius - position;
    const float distance = length(way);
    const float nearest = std::max(distance, kNearestLamp * lamp.radius);
    return {normalized(way), distance, kLamplight * (lamp.intensity / square(nearest))};
}

}  // namespace

std::optional<LightSample> sample_light(const Lighting& lighting, const Vec3& position, const Vec3& normal,
                                        SampleSequence& random) {
    const auto [choice, unused] = random.next();
    const auto [x, y] = random.next_in_disc();
    const std::size_t lights = (lighting.to_sun ? 1U : 0U) + lighting.lamps.size();
    const auto expected = [&](std::size_t index) { return expected_light(lighting, index, position, normal); };
    float sum = 0.0f;
    for (std::size_t i = 0; i < lights; ++i)
        sum += expected(i);
    if (sum <= 0.0f) return {};
    std::size_t pick = 0;
    float left = choice * sum;
    while (pick + 1 < lights && left >= expected(pick))
        left -= expected(pick++);
    const float chance = expected(pick) / sum;
    if (chance <= 0.0f) return {};
    LightSample sample = pick < lighting.lamps.size() ? lamplight(lighting.lamps[pick], position, x, y)
                                                      : sunlight(*lighting.to_sun, x, y);
    sample.light = sample.light * (1.0f / chance);
    return sample;
}

}  // namespace clbvh::tool
