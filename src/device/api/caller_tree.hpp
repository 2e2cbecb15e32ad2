#pragma once

#include "device/api/caller_memory.hpp"
#include "device/tree/parents.hpp"

namespace clbvh::device {

/// A tree of the caller's, looked at.
struct CallerTree {
    TreeNodes tree;  ///< the nodes as a view
    CallerMemory nodes;
    CallerMemory active_count;  ///< empty where there is none
};

/// Looks at where a tree's active count is, which may be nowhere. Throws Error(invalid_input) that names what is wrong.
[[nodiscard]] CallerMemory examine_active_count(const Session& session, const DeviceSpan& span);

/// Looks at a tree of at least one node that kernels write through views, and whose active count they read. Throws
/// Error(invalid_input) that names what is wrong; everything but values is checked.
[[nodiscard]] CallerTree check_tree(const Session& session, const DeviceBvh& given, std::uint64_t alignment);

}  // namespace clbvh::device
