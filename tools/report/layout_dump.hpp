#pragma once

#include <clbvh/io/layout_file.hpp>
#include <string>

namespace clbvh::tool {

/// What a layout's file holds, as JSON: its kind, counts and bytes. docs/dump.md lists the fields.
[[nodiscard]] std::string layout_json(const LayoutFileInfo& info);

}  // namespace clbvh::tool
