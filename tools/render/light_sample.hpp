#pragma once

#include <clbvh/core/aabb.hpp>
#include <limits>
#include <optional>

#include "render/lighting.hpp"
#include "render/sample_sequence.hpp"

namespace clbvh::tool {

/// Light that comes to a point if nothing is between.
struct LightSample {
    Vec3 direction;  ///< To where it comes from, of length 1.
    float distance = std::numeric_limits<float>::infinity();
    Vec3 light;  ///< On a surface at right angles to it, divided by the chance that it was chosen.
};

/// One of the lights, chosen by what each can be expected to give to a surface with this normal, and a place on it.
/// Nothing where none shines on the surface.
[[nodiscard]] std::optional<LightSample> sample_light(const Lighting& lighting, const Vec3& position,
                                                      const Vec3& normal, SampleSequence& random);

}  // namespace clbvh::tool
