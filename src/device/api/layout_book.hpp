#pragma once

#include "device/api/caller_memory.hpp"

// Which layouts in the caller's memory are true to their trees, for the whole process, in the order in which work is
// enqueued. Nothing of it costs the device anything, and a layout that is older than its tree cannot be traced.
namespace clbvh::device {

/// All that kernels are enqueued to write to: layouts there, and layouts of trees there, are no longer true.
void note_written(const CallerMemory& memory);

/// A layout of the tree that is in `nodes` was enqueued.
void note_layout(const CallerMemory& layout, const CallerMemory& nodes);

/// Throws Error(invalid_input) unless the layout was made of the tree in `nodes`, and neither was written since.
void check_layout_of(const CallerMemory& layout, const CallerMemory& nodes);

}  // namespace clbvh::device
