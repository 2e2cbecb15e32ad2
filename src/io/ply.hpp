#pragma once

#include <filesystem>

#include "clbvh/core/mesh.hpp"

namespace clbvh::io {

/// Reads the triangles of a PLY file, ASCII or binary of either byte order: element `vertex` with x, y and z of any
/// type, then element `face` with a list vertex_indices (or vertex_index), polygons triangulated. Other elements and
/// properties are skipped. Throws Error(io) with the file, and the header's line or the vertex or face at fault.
///
/// An own reader: assimp is fast enough, but reads beyond the end of a truncated file and takes counts on trust.
[[nodiscard]] Mesh load_ply(const std::filesystem::path& path);

}  // namespace clbvh::io
