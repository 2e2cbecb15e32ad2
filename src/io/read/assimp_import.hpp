#pragma once

#include <filesystem>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Reads the triangles of rare formats through assimp: every node of the scene in depth-first order with its transform
/// applied, points and lines counted. Nothing here vouches for assimp: version 5.2.5 crashes over some broken files.
/// Throws Error(io) with the file and assimp's reason, and Error(unsupported) for a format that assimp does not know or
/// where the library was configured without assimp.
void read_with_assimp(const std::filesystem::path& path, MeshSink& sink);

}  // namespace clbvh::io
