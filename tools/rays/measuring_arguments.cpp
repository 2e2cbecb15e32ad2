#include "rays/measuring_arguments.hpp"

#include <CLI/CLI.hpp>
#include <clbvh/core/error.hpp>
#include <clbvh/metrics/epo.hpp>
#include <string>

namespace clbvh::tool {

void MeasuringArguments::add_options(CLI::App& command) {
    command.add_option("--runs", runs, "Timed rounds, after one that warms up, 1 to 1000")
        ->check(CLI::Range(1, 1000))
        ->type_name("N")
        ->capture_default_str();
    command
        .add_option("--epo-samples", epo_samples,
                    "Estimate EPO from so many points, 2 to 2^32, which is faster where large triangles meet many "
                    "boxes; exact unless given")
        ->check(CLI::Range(kFewestEpoSamples, kMostEpoSamples))
        ->type_name("N");
}

void require_one_kind(const RayArguments& rays, std::string_view who) {
    if (rays.kinds.size() == 1) return;
    throw Error(ErrorCode::invalid_input, "--rays: " + std::string(who) + " about one kind of rays; give one");
}

}  // namespace clbvh::tool
