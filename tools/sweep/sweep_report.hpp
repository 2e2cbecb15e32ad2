#pragma once

#include <span>
#include <string>

#include "measure/build_result.hpp"

namespace clbvh::tool {

/// The table of one sweep over one scene: what each value costs each builder, and what the tree is worth. The results
/// of a builder follow each other; at least one.
[[nodiscard]] std::string sweep_report(const std::string& scene, std::span<const BuildResult> results);

}  // namespace clbvh::tool
