#pragma once

#include <clbvh/device/context.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "cli/scene_arguments.hpp"
#include "measure/build_result.hpp"

namespace clbvh::tool {

/// The report of `build`: a line for each thing worth knowing, and the table of stages. `output` is the file that the
/// tree was written to; empty where it was not.
[[nodiscard]] std::string build_report(const std::optional<Context>& context, const SceneArguments& loading,
                                       const BuildResult& result, double load_ms, std::string_view output);

}  // namespace clbvh::tool
