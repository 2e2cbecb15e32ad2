#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>

namespace clbvh::tool {

struct FreeHugeMemory {
    // The memory comes from std::aligned_alloc. NOLINTNEXTLINE(cppcoreguidelines-no-malloc)
    void operator()(std::byte* memory) const { std::free(memory); }
};

/// Owns memory of allocate_huge_memory.
using HugeMemory = std::unique_ptr<std::byte, FreeHugeMemory>;

/// At least `bytes` of uninitialised memory on huge pages, which the library's own builders ask for too. Throws
/// Error(out_of_memory) that says what it was for.
[[nodiscard]] HugeMemory allocate_huge_memory(std::size_t bytes, const char* what_for);

}  // namespace clbvh::tool
