#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// What loading a scene found beside the mesh.
struct LoadReport {
    std::uint64_t meshes = 1;  ///< Meshes of a glTF file that are shown, solids of an STL file, objects of an OBJ file.
    std::uint64_t instances = 1;         ///< Places where they stand. All are in the mesh, one behind the other.
    std::uint64_t faces = 0;             ///< Polygons and triangles, those that are skipped included.
    std::uint64_t skipped_faces = 0;     ///< Faces of fewer than three corners.
    std::uint64_t points_and_lines = 0;  ///< Elements that are no faces, and are skipped.
    /// Polygons that became a fan, in part or whole, which may overlap itself: because they intersect themselves, hold
    /// a NaN, or took too much work.
    std::uint64_t overlapping_fans = 0;
};

/// How a scene is loaded.
struct LoadOptions {
    ProgressCallback progress;     ///< Called now and then, with stage "load"; false throws Error(cancelled).
    LoadReport* report = nullptr;  ///< Where the report goes; null: nowhere.
    /// Most bytes of the mesh where a file is small and the mesh need not be: glTF's instances. More is an
    /// Error(out_of_memory). 0: half of the machine's memory.
    std::uint64_t max_bytes = 0;
};

/// Loads a mesh from `scene`: a generated scene "gen:NAME[:COUNT[:SEED]]", where NAME may be NAME:PARAMETER for
/// generators that have one, or a path to an OBJ, PLY, STL, OFF, glTF or GLB file, or, where the library was configured
/// with assimp, to whatever else assimp reads. Polygons are cut into triangles; faces of fewer than three corners are
/// skipped. Throws Error(io) naming the file and the line, byte or element at fault; Error(invalid_input) for an
/// unknown generator, a malformed count or seed; Error(unsupported) for a format, or an extension of glTF, that this
/// build cannot read; Error(cancelled); Error(out_of_memory).
[[nodiscard]] CLBVH_IO_API Mesh load_scene(std::string_view scene, const LoadOptions& options = {});

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
