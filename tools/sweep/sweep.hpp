#pragma once

#include <clbvh/catalog.hpp>
#include <clbvh/options.hpp>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cli/builder_choice.hpp"

namespace clbvh::tool {

/// One thing that a benchmark varies while everything else stays.
struct Sweep {
    std::string_view what;              ///< "radius", "size", "chunk" or "threshold".
    std::string_view option;            ///< The option that it sets; empty where it sets none.
    std::vector<std::uint32_t> values;  ///< Empty for "size", whose values depend on the scene.
};

/// The names of all sweeps, in the order in which help lists them.
[[nodiscard]] const std::vector<std::string>& sweep_names();

/// The sweep of that name, which must be one of sweep_names().
[[nodiscard]] const Sweep& find_sweep(std::string_view name);

/// Sets what is swept.
void set_swept(const Sweep& sweep, BuildOptions& options, std::uint32_t value);

/// Leaves those of `choice` that read what is swept. Throws Error(invalid_input) for one that was asked for by its id
/// and does not, or where none is left, naming those that do.
void keep_readers(const Sweep& sweep, BuilderChoice& choice);

/// Sizes from 10^4 to `largest` (at least 10^4), each about 3.16 times the one before; the last is `largest`.
[[nodiscard]] std::vector<std::uint32_t> sweep_sizes(std::uint32_t largest);

/// The sizes up to `largest`, or to the scene's own count where that is 0. Throws Error(invalid_input) naming the scene
/// where it is not a generated one, or too small; require_scene passes it.
[[nodiscard]] std::vector<std::uint32_t> sweep_sizes(const std::string& scene, std::uint32_t largest);

/// The generated scene `scene` with `count` triangles: "gen:NAME:COUNT[:SEED]".
[[nodiscard]] std::string with_count(const std::string& scene, std::uint32_t count);

}  // namespace clbvh::tool
