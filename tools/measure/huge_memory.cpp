#include "measure/huge_memory.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <clbvh/core/error.hpp>
#include <string>

namespace clbvh::tool {

HugeMemory allocate_huge_memory(std::size_t bytes, const char* what_for) {
    constexpr std::size_t page = std::size_t{2} << 20;
    const std::size_t whole_pages = (bytes / page + 1) * page;
    HugeMemory memory(static_cast<std::byte*>(std::aligned_alloc(page, whole_pages)));
    if (!memory) throw Error(ErrorCode::out_of_memory, std::string("no memory for ") + what_for);
#if defined(__linux__)
    // Advice only: without huge pages everything still works.
    static_cast<void>(madvise(memory.get(), whole_pages, MADV_HUGEPAGE));
#endif
    return memory;
}

}  // namespace clbvh::tool
