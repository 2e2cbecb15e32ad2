#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Loads a mesh from `scene`: a generated scene "gen:NAME[:COUNT[:SEED]]", where NAME may be
/// NAME:PARAMETER for generators that have one, or a path to an OBJ or PLY file, or, where
/// the library was configured with assimp, to glTF, GLB, STL and whatever else assimp reads. Throws Error(io) naming
/// the file, and the line where a line is at fault; Error(invalid_input) for an unknown generator, a malformed count or
/// seed; Error(unsupported) for a format that this build cannot read, saying what would.
[[nodiscard]] CLBVH_IO_API Mesh load_scene(std::string_view scene);

/// What a generator may be told beside count and seed.
struct SceneParameter {
    std::string_view name;         ///< As in "gen:NAME:D"; empty where there is none.
    std::string_view description;  ///< A few words for people.
    double standard = 0.0;         ///< Where it is not given.
    double most = 0.0;             ///< The largest possible.
    double least = 0.0;            ///< The smallest possible.
};

/// One generator of test scenes.
struct SceneGeneratorInfo {
    std::string_view name;         ///< As in "gen:NAME".
    std::string_view description;  ///< One line for people.
    SceneParameter parameter{};
};

/// All generators, in the order in which tables list them.
[[nodiscard]] CLBVH_IO_API std::span<const SceneGeneratorInfo> scene_generators() noexcept;

/// The parts of "gen:NAME[:COUNT[:SEED]]".
struct GeneratedScene {
    std::string name;  ///< A generator's, or NAME:PARAMETER where it has one.
    std::optional<std::uint64_t> count;
    std::optional<std::uint64_t> seed;
};

/// Whether `scene` is a generated one, and not a path.
[[nodiscard]] CLBVH_IO_API bool is_generated_scene(std::string_view scene) noexcept;

/// Takes the name of a generated scene apart. Throws Error(invalid_input) naming the scene where there is no such
/// generator, or a number is none or out of its range.
[[nodiscard]] CLBVH_IO_API GeneratedScene parse_generated_scene(std::string_view scene);

/// Default number of triangles of a generated scene.
inline constexpr std::uint64_t kDefaultSceneTriangles = 100000;

/// Makes a scene of exactly `count` triangles, the same for the same arguments on every platform.
/// `name` is a generator's, or NAME:PARAMETER. Throws Error(invalid_input) for an unknown name, a parameter out of its
/// range, or a count over kMaxPrimitives.
[[nodiscard]] CLBVH_IO_API Mesh generate_scene(std::string_view name, std::uint64_t count = kDefaultSceneTriangles,
                                               std::uint64_t seed = 1);

}  // namespace clbvh
