#pragma once

#include <clbvh/device/context.hpp>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "cli/builder_choice.hpp"
#include "measure/build_result.hpp"

namespace clbvh::tool {

/// The table of one scene: what each builder cost, and what its tree is worth. At least one result.
[[nodiscard]] std::string scene_report(const std::optional<Context>& context, std::span<const BuildResult> results);

/// Geometric means of each builder over several scenes. `results` holds scene after scene, and for each of them the
/// same `builder_count` builders in the same order.
[[nodiscard]] std::string means_report(std::span<const BuildResult> results, std::size_t builder_count);

/// Which builders cannot run here and why; empty where all can.
[[nodiscard]] std::string unavailable_report(const BuilderChoice& choice);

}  // namespace clbvh::tool
