#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/eval/camera.hpp>
#include <clbvh/eval/ray_sets.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "cli/cli_fwd.hpp"
#include "measure/ray_cost.hpp"

namespace clbvh::tool {

/// Which rays a command traces.
class RayArguments {
public:
    std::vector<RayKind> kinds{RayKind::diffuse};
    std::uint64_t count = 1 << 18;
    std::uint64_t seed = 1;
    std::string load_from;  ///< A ray file; empty where rays are made.
    std::string save_to;    ///< Empty where they are not kept.

    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
    /// Throws Error(invalid_input) where the options do not fit together or the number of scenes, Error(io) where a
    /// file cannot be read or written.
    void check(std::size_t scene_count) const;

    /// The set of that kind for a scene, and writes it where that was asked for. Throws Error(invalid_input) where the
    /// camera sees nothing that rays could come from.
    [[nodiscard]] RaySet rays(RayKind kind, const std::string& scene, const Mesh& mesh, const ClosestHits& trace,
                              const Camera& camera) const;
};

}  // namespace clbvh::tool
