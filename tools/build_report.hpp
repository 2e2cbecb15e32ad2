#pragma once

#include <clbvh/device/context.hpp>
#include <optional>
#include <string>

#include "build_result.hpp"

namespace clbvh::tool {

/// What `build` tells people: a line for each thing worth knowing, and the table of stages.
[[nodiscard]] std::string build_report(const std::optional<Context>& context, const BuildResult& result,
                                       double load_ms);

}  // namespace clbvh::tool
