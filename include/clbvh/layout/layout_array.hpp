#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>

#include "clbvh/export.h"

namespace clbvh {

namespace layout_detail {

struct CLBVH_API FreeArray {
    void operator()(std::byte* memory) const noexcept;
};
using ArrayMemory = std::unique_ptr<std::byte[], FreeArray>;

/// Uninitialised, aligned to 64 bytes, in huge pages where there is enough for one: rays jump about in layouts, and
/// would spend a good part of their time on address translation. Throws Error(out_of_memory).
[[nodiscard]] CLBVH_API ArrayMemory allocate_array(std::uint64_t bytes);

}  // namespace layout_detail

/// The elements of a layout: plain data, one behind the other, aligned to 64 bytes. Its memory stays when it gets
/// smaller, so that a layout that is made again and again is allocated once.
template <typename T>
class LayoutArray {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 64);

public:
    LayoutArray() = default;
    LayoutArray(const LayoutArray& other) { *this = other; }
    LayoutArray(LayoutArray&& other) noexcept { swap(other); }
    LayoutArray& operator=(const LayoutArray& other) {
        if (this == &other) return *this;
        resize_for_overwrite(other.size_);
        if (size_ > 0) std::memcpy(static_cast<void*>(data()), other.data(), size_ * sizeof(T));
        return *this;
    }
    LayoutArray& operator=(LayoutArray&& other) noexcept {
        swap(other);
        return *this;
    }
    ~LayoutArray() = default;

    /// Makes it `size` elements long, which hold anything. Throws Error(out_of_memory), and then keeps what it had.
    void resize_for_overwrite(std::size_t size) {
        if (size > capacity_) {
            memory_ = layout_detail::allocate_array(std::uint64_t{size} * sizeof(T));
            capacity_ = size;
        }
        size_ = size;
    }

    void clear() noexcept { size_ = 0; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
    [[nodiscard]] T* data() noexcept { return reinterpret_cast<T*>(memory_.get()); }
    [[nodiscard]] const T* data() const noexcept { return reinterpret_cast<const T*>(memory_.get()); }
    [[nodiscard]] T* begin() noexcept { return data(); }
    [[nodiscard]] T* end() noexcept { return data() + size_; }
    [[nodiscard]] const T* begin() const noexcept { return data(); }
    [[nodiscard]] const T* end() const noexcept { return data() + size_; }
    [[nodiscard]] T& operator[](std::size_t i) noexcept { return data()[i]; }
    [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return data()[i]; }

private:
    void swap(LayoutArray& other) noexcept {
        std::swap(memory_, other.memory_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }

    layout_detail::ArrayMemory memory_;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace clbvh
