#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

#include "core/huge_pages.hpp"

namespace clbvh::trace {

/// A copy of an array that does not change any more, in huge pages: rays jump about in it, and would spend a good part
/// of their time on address translation. Aligned to 64 bytes. Throws Error(out_of_memory) or std::bad_alloc.
template <typename T>
class HugePageArray {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 64);

public:
    HugePageArray() = default;
    explicit HugePageArray(std::span<const T> elements)
        : memory_(allocate(elements.size_bytes())), size_(elements.size()) {
        std::uninitialized_copy(elements.begin(), elements.end(), reinterpret_cast<T*>(memory_.get()));
    }

    [[nodiscard]] const T* data() const noexcept { return reinterpret_cast<const T*>(memory_.get()); }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return data()[i]; }

private:
    /// Arrays that would fill only a small part of a huge page get none.
    static HugePageMemory allocate(std::size_t bytes) {
        if (bytes >= kHugePage / 4) return allocate_in_huge_pages(bytes);
        HugePageMemory memory(static_cast<std::byte*>(std::aligned_alloc(64, bytes / 64 * 64 + 64)));
        if (memory == nullptr) throw std::bad_alloc();
        return memory;
    }

    HugePageMemory memory_;
    std::size_t size_ = 0;
};

}  // namespace clbvh::trace
