#pragma once

#include <filesystem>
#include <string_view>

#include "io/read/mesh_sink.hpp"

namespace clbvh::io {

/// Reads the triangles of a glTF 2.0 file, .gltf or .glb, as its scene shows them: every mesh at every node, with its
/// transform, in depth-first order; instances of EXT_mesh_gpu_instancing; morph targets with the weights of the node or
/// the mesh; skins with the joints where they stand. Triangles, strips and fans, indexed or not; points and lines are
/// counted. Coordinates are floats, or integers as KHR_mesh_quantization has them; accessors may be sparse. Buffers are
/// those of the file, in base64, or in files of `folder` or below it. Throws Error(io) with the file and the place in
/// it, and Error(unsupported) for what the file requires and nobody here knows.
void read_gltf(std::string_view text, const std::filesystem::path& folder, MeshSink& sink);

}  // namespace clbvh::io
