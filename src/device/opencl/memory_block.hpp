#pragma once

#include <cstdint>
#include <utility>

#include "device/opencl/opencl.hpp"

namespace clbvh::device {

/// A buffer, or the part of one that begins at `offset`.
struct Block {
    cl::Buffer buffer;
    std::uint64_t offset = 0;

    [[nodiscard]] bool is_there() const noexcept { return buffer() != nullptr; }
    /// The block that begins `bytes` further on.
    [[nodiscard]] Block behind(std::uint64_t bytes) const { return {buffer, offset + bytes}; }
};

/// Part of `block` as a buffer of its own. `offset` is a multiple of the device's alignment (see kViewAlignment).
[[nodiscard]] cl::Buffer view_of(const Block& block, std::uint64_t offset, std::uint64_t bytes);

/// Where views may begin, on every device.
inline constexpr std::uint64_t kViewAlignment = 4096;

/// Arrays that lie one behind the other in a block. What cuts a block says how large it has to be: without a buffer the
/// same calls only add up bytes.
class ArrayLayout {
public:
    explicit ArrayLayout(Block block = {}, std::uint64_t alignment = kViewAlignment)
        : block_(std::move(block)), alignment_(alignment) {}

    /// The place of the next `bytes`; without a buffer, where it would be.
    Block take(std::uint64_t bytes) {
        const std::uint64_t begin = (end_ + alignment_ - 1) / alignment_ * alignment_;
        end_ = begin + bytes;
        return block_.behind(begin);
    }
    /// The next `bytes` as a buffer of their own; a null buffer without one, or where there are none.
    cl::Buffer take_view(std::uint64_t bytes) {
        const Block place = take(bytes);
        return place.is_there() && bytes > 0 ? view_of(place, 0, bytes) : cl::Buffer();
    }
    /// From the beginning to the end of what was taken.
    [[nodiscard]] std::uint64_t bytes() const noexcept { return end_; }

private:
    Block block_;
    std::uint64_t alignment_;
    std::uint64_t end_ = 0;
};

}  // namespace clbvh::device
