#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "clbvh/core/aabb.hpp"

namespace clbvh::io {

/// Checks every vertex and face line of an OBJ file, and returns its vertices. tinyobjloader reads `v 1 abc 3` and
/// `v 1 nan 3` as (1, 0, 3), takes `f 1 2` and keeps indices that are out of range; here a NaN is kept, and the others
/// are an Error(io) with the file and line. Faces may refer to vertices that come after them.
[[nodiscard]] std::vector<Vec3> scan_obj(std::string_view text, const std::filesystem::path& path);

}  // namespace clbvh::io
