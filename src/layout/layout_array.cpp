#include "clbvh/layout/layout_array.hpp"

#include <cstdlib>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/huge_pages.hpp"

namespace clbvh::layout_detail {
namespace {

constexpr std::uint64_t kAlignment = 64;

}  // namespace

void FreeArray::operator()(std::byte* memory) const noexcept {
    FreeMemory{}(memory);
}

ArrayMemory allocate_array(std::uint64_t bytes) {
    if (bytes == 0) return {};
    // Arrays that would fill only a small part of a huge page get none.
    if (bytes >= kHugePage / 4) return ArrayMemory(allocate_in_huge_pages(bytes).release());
    const std::uint64_t rounded = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    ArrayMemory memory(static_cast<std::byte*>(std::aligned_alloc(kAlignment, rounded)));
    if (memory == nullptr) {
        throw Error(ErrorCode::out_of_memory,
                    "the host has no " + std::to_string(rounded) + " bytes left for a layout");
    }
    return memory;
}

}  // namespace clbvh::layout_detail
