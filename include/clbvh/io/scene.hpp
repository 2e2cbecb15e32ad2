#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Loads a mesh from `scene`: a generated scene "gen:NAME[:COUNT[:SEED]]", or a path to an OBJ or PLY file, or, where
/// the library was configured with assimp, to glTF, GLB, STL and whatever else assimp reads. Throws Error(io) naming
/// the file, and the line where a line is at fault; Error(invalid_input) for an unknown generator, a malformed count or
/// seed; Error(unsupported) for a format that this build cannot read, saying what would.
[[nodiscard]] CLBVH_IO_API Mesh load_scene(std::string_view scene);

/// One generator of test scenes.
struct SceneGeneratorInfo {
    std::string_view name;         ///< As in "gen:NAME".
    std::string_view description;  ///< One line for people.
};

/// All generators, in the order in which tables list them.
[[nodiscard]] CLBVH_IO_API std::span<const SceneGeneratorInfo> scene_generators() noexcept;

/// Default number of triangles of a generated scene.
inline constexpr std::uint64_t kDefaultSceneTriangles = 100000;

/// Makes a scene of exactly `count` triangles, the same for the same arguments on every platform.
/// Throws Error(invalid_input) for an unknown name or a count over kMaxPrimitives.
[[nodiscard]] CLBVH_IO_API Mesh generate_scene(std::string_view name, std::uint64_t count = kDefaultSceneTriangles,
                                               std::uint64_t seed = 1);

}  // namespace clbvh
