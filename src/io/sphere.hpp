#pragma once

#include <cstdint>

#include "clbvh/core/mesh.hpp"

namespace clbvh::io {

/// A sphere of radius 1 from exactly `count` triangles. Closed for every even count from 8; an odd count lacks one
/// triangle, and a smaller one takes some of the octahedron's.
[[nodiscard]] Mesh make_sphere(std::uint64_t count);

}  // namespace clbvh::io
