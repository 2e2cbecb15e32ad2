#pragma once

#include <cstdint>

namespace clbvh {

/// The layouts, as numbered in files.
enum class LayoutKind : std::uint32_t { wide8 = 1, wide4 = 2, compressed8 = 3, pair = 4, skip = 5 };

}  // namespace clbvh
