#pragma once

#include <initializer_list>
#include <string_view>

#include "clbvh/device/memory.hpp"
#include "device/opencl/memory_block.hpp"
#include "device/opencl/session.hpp"

namespace clbvh::device {

/// Memory of the caller's that was looked at.
struct CallerMemory {
    std::string_view name;      ///< what errors call it
    Block given;                ///< as the caller has it
    std::uint64_t bytes = 0;    ///< how many are used
    Block place;                ///< the same memory in the buffer that this is a sub-buffer of, or in itself
    bool is_readable = true;    ///< for kernels
    bool is_read_write = true;  ///< for kernels

    [[nodiscard]] bool is_there() const noexcept { return given.is_there(); }
};

/// Looks at `span`, of which `bytes` are to be used. Throws Error(invalid_input) where it is not memory of this context
/// or too small.
[[nodiscard]] CallerMemory examine(const Session& session, std::string_view name, const DeviceSpan& span,
                                   std::uint64_t bytes);

/// Throws Error(invalid_input) where kernels may not both read and write the memory.
void check_read_write(const CallerMemory& memory);

/// Throws Error(invalid_input) where the memory does not begin at a multiple of `alignment`, a power of two.
void check_aligned(const CallerMemory& memory, std::uint64_t alignment);

/// Both: what cutting views out of the memory takes.
void check_views_allowed(const CallerMemory& memory, std::uint64_t alignment);

/// Throws Error(invalid_input) where kernels may not read the memory.
void check_readable(const CallerMemory& memory);

/// Throws Error(invalid_input) where `memory` is used as it is, and lies in a buffer that kernels write through views
/// of `cut`: OpenCL leaves it undefined what a kernel then reads. Disjoint sub-buffers are another matter.
void check_in_other_buffer(const CallerMemory& memory, std::initializer_list<CallerMemory> cut);

/// Throws Error(invalid_input) where `value`, called `what`, is below `least` or no multiple of `step`.
void check_multiple(std::string_view what, std::uint64_t value, std::uint64_t least, std::uint64_t step);

/// Throws Error(invalid_input) where two of them overlap.
void check_apart(std::initializer_list<CallerMemory> memories);

/// Alignment of views of buffers, in bytes.
[[nodiscard]] std::uint64_t view_alignment(const Session& session);

}  // namespace clbvh::device
