#pragma once

#include <string_view>

#include "clbvh/export.h"

namespace clbvh {

/// Source text in OpenCL C 1.2 that traces rays through the library's trees inside kernels of the caller's own: put it
/// before them in a program. It needs nothing else. See docs/embed.md; the installed file
/// share/clbvh/kernels/clbvh_trace.clh is the same. Ends with a null character, which does not count. No OpenCL is
/// needed to have it.
[[nodiscard]] CLBVH_API std::string_view embed_source() noexcept;

}  // namespace clbvh
