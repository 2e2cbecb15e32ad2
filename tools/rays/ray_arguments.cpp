#include "rays/ray_arguments.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <clbvh/core/error.hpp>
#include <clbvh/io/ray_file.hpp>
#include <optional>
#include <string_view>

#include "cli/output_file.hpp"

namespace clbvh::tool {
namespace {

constexpr std::uint64_t kMostRays = std::uint64_t{1} << 30;

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_input, what);
}

RayKind require_kind(std::string_view name) {
    if (const std::optional<RayKind> kind = ray_kind_from(name)) return *kind;
    throw CLI::ValidationError("--rays", fmt::format("'{}' is no kind of rays; there are primary, diffuse, shadow, ao "
                                                     "and random, several with commas between them",
                                                     name));
}

/// Each kind once.
std::vector<RayKind> kinds_in(std::string_view list) {
    std::vector<RayKind> kinds;
    for (std::size_t begin = 0; begin <= list.size();) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        const RayKind kind = require_kind(list.substr(begin, end - begin));
        if (std::ranges::find(kinds, kind) == kinds.end()) kinds.push_back(kind);
        begin = end + 1;
    }
    return kinds;
}

}  // namespace

void RayArguments::add_options(CLI::App& command) {
    command
        .add_option_function<std::string>(
            "--rays", [this](const std::string& list) { kinds = kinds_in(list); },
            "primary, diffuse, shadow, ao or random; several with commas between them")
        ->type_name("KIND")
        ->default_str("diffuse");
    command.add_option("--count", count, "About how many rays, 1 to 2^30")
        ->check(CLI::Range(std::uint64_t{1}, kMostRays))
        ->type_name("N")
        ->capture_default_str();
    command.add_option("--seed", seed, "Of the rays' random numbers")->type_name("N")->capture_default_str();
    command.add_option("--load-rays", load_from, "Trace the rays of this file, as rays of the one kind of --rays")
        ->type_name("FILE");
    command.add_option("--save-rays", save_to, "Write the rays to this file, for --load-rays")->type_name("FILE");
}

void RayArguments::check(std::size_t scene_count) const {
    for (const auto& [name, file] : {std::pair{"--load-rays", &load_from}, std::pair{"--save-rays", &save_to}}) {
        if (file->empty()) continue;
        if (scene_count != 1) refuse(fmt::format("{} is for one scene, and there are {}", name, scene_count));
        if (kinds.size() != 1)
            refuse(fmt::format("{} is for one kind of --rays, and there are {}", name, kinds.size()));
    }
    if (!load_from.empty()) static_cast<void>(read_rays(load_from));
    if (!save_to.empty()) require_writable(save_to);
}

RaySet RayArguments::rays(RayKind kind, const std::string& scene, const Mesh& mesh, const ClosestHits& trace,
                          const Camera& camera) const {
    RaySet set{kind, {}};
    set.rays = load_from.empty() ? make_rays(kind, mesh, trace, camera, {count, seed}) : read_rays(load_from);
    if (set.rays.empty()) {
        refuse(fmt::format("{}: there are no {} rays{}", scene, to_string(kind),
                           kind == RayKind::random ? ": the scene has no surface"
                                                   : ": nothing is seen from where they would come; see --camera"));
    }
    if (!save_to.empty()) write_rays(set.rays, save_to);
    return set;
}

}  // namespace clbvh::tool
