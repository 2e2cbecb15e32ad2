#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>

namespace clbvh {

struct FreeMemory {
    // The memory comes from std::aligned_alloc. NOLINTNEXTLINE(cppcoreguidelines-no-malloc)
    void operator()(void* memory) const noexcept { std::free(memory); }
};

/// Owns memory of allocate_in_huge_pages.
using HugePageMemory = std::unique_ptr<std::byte, FreeMemory>;

/// Size of a huge page, and what memory of allocate_in_huge_pages is aligned to.
inline constexpr std::uint64_t kHugePage = std::uint64_t{2} << 20;

/// At least `bytes` of uninitialised memory, aligned to kHugePage, for which the system was asked for huge pages:
/// random accesses otherwise spend a good part of their time on address translation. Throws Error(out_of_memory).
[[nodiscard]] HugePageMemory allocate_in_huge_pages(std::uint64_t bytes);

}  // namespace clbvh
