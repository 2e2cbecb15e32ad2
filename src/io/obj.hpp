#pragma once

#include <filesystem>

#include "clbvh/core/mesh.hpp"

namespace clbvh::io {

/// Reads the triangles of an OBJ file, all objects and groups in the file's order, polygons triangulated. A coordinate
/// may be `nan`. Throws Error(io) with the file, and the line where a line is at fault.
[[nodiscard]] Mesh load_obj(const std::filesystem::path& path);

}  // namespace clbvh::io
