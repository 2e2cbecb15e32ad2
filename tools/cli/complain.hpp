#pragma once

#include <string>

namespace clbvh::tool {

/// Writes "clbvh: TEXT" and the end of a line to standard error. Where that is closed or full there is nobody to tell,
/// and the exit code has to do.
void complain(const std::string& text) noexcept;

}  // namespace clbvh::tool
