#pragma once

#include <string_view>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Reads the triangles of a PLY file, ASCII or binary of either byte order: element `vertex` with x, y and z of any
/// type, then elements `face` (polygons) or `tristrips` (triangle strips, which -1 parts), or both, with a list
/// vertex_indices or vertex_index. Other elements and properties are skipped, and so are, in ASCII, numbers at the end
/// of rows that are longer than the header says. Throws Error(io) with the file, and the header's line or the vertex or
/// face at fault.
///
/// An own reader: assimp is fast enough, but reads beyond the end of a truncated file and takes counts on trust.
void read_ply(std::string_view text, MeshSink& sink);

}  // namespace clbvh::io
