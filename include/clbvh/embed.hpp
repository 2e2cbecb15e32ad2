#pragma once

#include <string_view>

#include "clbvh/export.h"

namespace clbvh {

/// Source text in OpenCL C 1.2 that traces rays through the library's trees, in any layout, inside kernels of the
/// caller's own: put it before them in a program. It needs nothing else. The macro CLBVH_LAYOUT says which layout
/// clbvh_closest, clbvh_any and clbvh_all are for; what a program does not call costs it nothing. See docs/embed.md;
/// the installed file share/clbvh/kernels/clbvh_trace.clh is the same. Ends with a null character, which does not
/// count. No OpenCL is needed to have it.
[[nodiscard]] CLBVH_API std::string_view embed_source() noexcept;

}  // namespace clbvh
