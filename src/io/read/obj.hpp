#pragma once

#include <string_view>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Reads the triangles of an OBJ file, all objects and groups in the file's order. A coordinate may be `nan`. Throws
/// Error(io) with the file, and the line where a line is at fault.
void read_obj(std::string_view text, MeshSink& sink);

}  // namespace clbvh::io
