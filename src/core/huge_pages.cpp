#include "core/huge_pages.hpp"

#include <string>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "clbvh/core/error.hpp"

namespace clbvh {

HugePageMemory allocate_in_huge_pages(std::uint64_t bytes) {
    const std::uint64_t rounded = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    HugePageMemory memory(static_cast<std::byte*>(std::aligned_alloc(kHugePage, rounded)));
    if (memory == nullptr) {
        throw Error(ErrorCode::out_of_memory, "the system has no " + std::to_string(rounded >> 20) + " MiB left");
    }
#if defined(__linux__)
    // Advice only: without huge pages everything still works.
    static_cast<void>(madvise(memory.get(), rounded, MADV_HUGEPAGE));
#endif
    return memory;
}

}  // namespace clbvh
