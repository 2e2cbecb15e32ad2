#pragma once

#include <clbvh/device/context.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>

#include "cli/scene_arguments.hpp"
#include "measure/build_result.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

[[nodiscard]] nlohmann::ordered_json to_json(const DeviceInfo& device);
[[nodiscard]] nlohmann::ordered_json sample_json(const Sample& sample);

/// The document of a command that builds: the machine, the device, null where none was opened, the file of its profile,
/// null where none is used, how scenes were turned, the options under their names in the table of options, and the
/// array `results`.
[[nodiscard]] nlohmann::ordered_json document_json(const std::optional<Context>& context, const SceneArguments& loading,
                                                   const BuildOptions& options, nlohmann::ordered_json results);

/// An array with one entry a result, each with the options in use where a preset or an optimizer may have set others
/// than those of the document.
[[nodiscard]] nlohmann::ordered_json to_json(std::span<const BuildResult> results);

}  // namespace clbvh::tool
