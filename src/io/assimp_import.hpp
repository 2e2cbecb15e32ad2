#pragma once

#include <filesystem>

#include "clbvh/core/mesh.hpp"

namespace clbvh::io {

/// Reads the triangles of whatever assimp reads: every node of the scene in depth-first order with its transform
/// applied, polygons triangulated, points and lines dropped. Throws Error(io) with the file and assimp's reason, and
/// Error(unsupported) for a format that assimp does not know or where the library was configured without assimp.
[[nodiscard]] Mesh load_with_assimp(const std::filesystem::path& path);

}  // namespace clbvh::io
