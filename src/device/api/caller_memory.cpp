#include "device/api/caller_memory.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

[[noreturn]] void refuse(std::string_view name, const std::string& reason) {
    throw Error(ErrorCode::invalid_input, std::string(name) + " " + reason);
}

Block place_of(const cl::Buffer& buffer, std::uint64_t offset) {
    const cl::Memory parent = buffer.getInfo<CL_MEM_ASSOCIATED_MEMOBJECT>();
    if (parent() == nullptr) return {buffer, offset};
    return {cl::Buffer(parent(), true), buffer.getInfo<CL_MEM_OFFSET>() + offset};
}

// The widest vector that kernels load and store, where the processor may insist on its alignment.
constexpr std::uint64_t kVectorBytes = 64;

// Devices with memory of their own lay it out as they must; the caller's stays where it is.
bool lies_aligned(const CallerMemory& memory, std::uint64_t bytes) {
    const cl::Buffer& buffer = memory.place.buffer;
    if ((buffer.getInfo<CL_MEM_FLAGS>() & CL_MEM_USE_HOST_PTR) == 0) return true;
    const auto address = reinterpret_cast<std::uintptr_t>(buffer.getInfo<CL_MEM_HOST_PTR>());
    return (address + memory.place.offset) % bytes == 0;
}

bool have_common_bytes(const CallerMemory& a, const CallerMemory& b) {
    return a.place.buffer() == b.place.buffer() && a.place.offset < b.place.offset + b.bytes &&
           b.place.offset < a.place.offset + a.bytes;
}

}  // namespace

CallerMemory examine(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes) {
    if (span.buffer == nullptr) refuse(name, "has no buffer");
    return with_opencl_errors(name, [&] {
        CallerMemory memory;
        memory.name = name;
        const cl::Buffer buffer(span.buffer, true);
        memory.given = {buffer, span.offset};
        memory.bytes = bytes;
        if (buffer.getInfo<CL_MEM_TYPE>() != CL_MEM_OBJECT_BUFFER) refuse(name, "is an image, not a buffer");
        if (buffer.getInfo<CL_MEM_CONTEXT>()() != session.context()()) {
            refuse(name, "belongs to another OpenCL context than the kernels");
        }
        const std::uint64_t size = buffer.getInfo<CL_MEM_SIZE>();
        if (span.offset > size || bytes > size - span.offset) {
            refuse(name, "needs " + std::to_string(bytes) + " bytes from offset " + std::to_string(span.offset) +
                             " on, but its buffer ends after " + std::to_string(size));
        }
        const cl_mem_flags flags = buffer.getInfo<CL_MEM_FLAGS>();
        memory.is_readable = (flags & CL_MEM_WRITE_ONLY) == 0;
        memory.is_read_write = (flags & (CL_MEM_READ_ONLY | CL_MEM_WRITE_ONLY)) == 0;
        memory.place = place_of(buffer, span.offset);
        return memory;
    });
}

void check_read_write(const CallerMemory& memory) {
    if (!memory.is_read_write) {
        refuse(memory.name, "must be a buffer with CL_MEM_READ_WRITE: kernels do both");
    }
}

void check_aligned(const CallerMemory& memory, std::uint64_t alignment) {
    if (memory.place.offset % alignment != 0) {
        refuse(memory.name, "begins " + std::to_string(memory.place.offset) +
                                " bytes into its memory, but must at a multiple of " + std::to_string(alignment));
    }
    const std::uint64_t host_alignment = std::min(alignment, kVectorBytes);
    if (!lies_aligned(memory, host_alignment)) {
        refuse(memory.name, "lies in host memory (CL_MEM_USE_HOST_PTR) that must be aligned to " +
                                std::to_string(host_alignment) + " bytes");
    }
}

void check_readable(const CallerMemory& memory) {
    if (!memory.is_readable) refuse(memory.name, "must not be a buffer with CL_MEM_WRITE_ONLY: kernels read it");
}

void check_in_other_buffer(const CallerMemory& memory, std::initializer_list<CallerMemory> cut) {
    for (const CallerMemory& other : cut) {
        if (memory.is_there() && memory.given.buffer() == other.place.buffer()) {
            refuse(memory.name, "and " + std::string(other.name) +
                                    " lie in one buffer, of which kernels write parts as sub-buffers; give the former "
                                    "a sub-buffer of its own, or another buffer");
        }
    }
}

void check_views_allowed(const CallerMemory& memory, std::uint64_t alignment) {
    check_read_write(memory);
    check_aligned(memory, alignment);
}

void check_multiple(std::string_view what, std::uint64_t value, std::uint64_t least, std::uint64_t step) {
    if (value < least || value % step != 0) {
        refuse(what, "is " + std::to_string(value) + ", but must be " +
                         (least > 0 ? "at least " + std::to_string(least) + " and " : "") + "a multiple of " +
                         std::to_string(step));
    }
}

void check_apart(std::initializer_list<CallerMemory> memories) {
    for (const CallerMemory* a = memories.begin(); a != memories.end(); ++a) {
        for (const CallerMemory* b = a + 1; b != memories.end(); ++b) {
            if (have_common_bytes(*a, *b)) refuse(a->name, "and " + std::string(b->name) + " overlap");
        }
    }
}

std::uint64_t view_alignment(const Session& session) {
    const auto device = session.queue().getInfo<CL_QUEUE_DEVICE>();
    return device.getInfo<CL_DEVICE_MEM_BASE_ADDR_ALIGN>() / 8;
}

}  // namespace clbvh::device
