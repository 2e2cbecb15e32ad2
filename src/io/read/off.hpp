#pragma once

#include <string_view>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Reads the triangles of an OFF file in ASCII: a vertex a line, then a face a line, of any number of corners; `#`
/// begins a comment. Of the variants, ST, C and N (what they add to a vertex stands behind its coordinates, and is
/// skipped) and 4 (a fourth coordinate, by which the others are divided) are read, nOFF and binary files refused. The
/// first line may lack the name, or hold the counts as well. Throws Error(io) with the file and line, and
/// Error(unsupported).
void read_off(std::string_view text, MeshSink& sink);

}  // namespace clbvh::io
