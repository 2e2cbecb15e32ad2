#pragma once

#include <string_view>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Reads the triangles of an STL file, binary (also where its header begins with "solid"; bytes behind the last
/// triangle are skipped) or ASCII (any number of solids, keywords in any case). Normals are skipped; each triangle has
/// vertices of its own. Throws Error(io) with the file, and the line or the triangle at fault.
void read_stl(std::string_view text, MeshSink& sink);

}  // namespace clbvh::io
