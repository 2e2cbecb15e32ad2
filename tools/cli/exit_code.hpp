#pragma once

namespace clbvh::tool {

inline constexpr int kExitSuccess = 0;
inline constexpr int kExitFailure = 1;      ///< A clbvh::Error; its message went to standard error.
inline constexpr int kExitUsage = 2;        ///< The command line is wrong.
inline constexpr int kExitInvalidTree = 3;  ///< A tree failed validation.
inline constexpr int kExitOnSignal = 128;   ///< Plus the signal's number, as shells report it: 130 for Ctrl-C.

}  // namespace clbvh::tool
