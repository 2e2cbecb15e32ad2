#pragma once

#include <cstdint>
#include <string_view>

#include "cli/cli_fwd.hpp"
#include "rays/ray_arguments.hpp"

namespace clbvh::tool {

/// How commands that hold trees' metrics against the cost of rays measure.
struct MeasuringArguments {
    std::uint32_t runs = 5;
    std::uint64_t epo_samples = 0;  ///< 0: exact.

    /// Adds the options to a command; parsing fills this object.
    void add_options(CLI::App& command);
};

/// Throws Error(invalid_input), naming --rays, where not just one kind of rays is asked for; `who` needs that.
void require_one_kind(const RayArguments& rays, std::string_view who);

}  // namespace clbvh::tool
