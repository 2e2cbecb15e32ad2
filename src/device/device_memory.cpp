#include "device/device_memory.hpp"

#include <cstdlib>
#include <memory>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kHugePage = std::uint64_t{2} << 20;

struct Free {
    void operator()(void* memory) const noexcept { std::free(memory); }
};

#if defined(__linux__)
void CL_CALLBACK free_host_memory(cl_mem, void* memory) {
    std::free(memory);
}

cl::Buffer allocate_in_huge_pages(const Session& session, std::uint64_t bytes) {
    const std::uint64_t rounded = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    std::unique_ptr<void, Free> memory(std::aligned_alloc(kHugePage, rounded));
    if (memory == nullptr) {
        throw Error(ErrorCode::out_of_memory, "the system has no " + std::to_string(rounded >> 20) + " MiB left");
    }
    // Advice only: without huge pages everything still works.
    static_cast<void>(madvise(memory.get(), rounded, MADV_HUGEPAGE));
    cl::Buffer buffer(session.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory.get());
    buffer.setDestructorCallback(free_host_memory, memory.get());
    static_cast<void>(memory.release());  // the callback owns it now
    return buffer;
}
#endif

}  // namespace

cl::Buffer allocate_buffer(const Session& session, std::uint64_t bytes) {
#if defined(__linux__)
    if (session.info().type == DeviceType::cpu && bytes >= kHugePage) {
        return allocate_in_huge_pages(session, bytes);
    }
#endif
    return {session.context(), CL_MEM_READ_WRITE, bytes};
}

}  // namespace clbvh::device
