#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Checks every line of an OBJ file that says something of its geometry. Adds the vertices to `sink`, counts faces of
/// less than three corners, points and lines there, and returns the other faces as lines `f` with nothing but indices
/// of vertices, counted from 1. So tinyobjloader, which reads them, sees no numbers that are not needed: it computes
/// with those that are out of range, reads `v 1 abc 3` as (1, 0, 3), and keeps indices that do not exist.
/// Lines may be continued by a backslash, and end in a comment; faces may refer to vertices that come after them.
/// Throws Error(io) with the file and line.
[[nodiscard]] std::string scan_obj(std::string_view text, MeshSink& sink);

}  // namespace clbvh::io
