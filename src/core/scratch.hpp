#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <type_traits>
#include <vector>

#include "core/huge_pages.hpp"

namespace clbvh {

/// Temporary memory of host builds. Arrays are handed out one after the other and all taken back at once; the memory
/// stays for the next build, because a first touch of fresh memory costs more than a build's own traffic.
class Scratch {
public:
    /// `count` uninitialised elements, aligned to 64 bytes, valid until reset(). Any thread may ask.
    /// Throws Error(out_of_memory).
    template <typename T>
    [[nodiscard]] std::span<T> take(std::size_t count) {
        static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= kAlignment);
        return {reinterpret_cast<T*>(take_bytes(count * sizeof(T))), count};
    }

    /// Takes all arrays back.
    void reset();

    /// Bytes handed out since the last reset().
    [[nodiscard]] std::uint64_t bytes_in_use() const;

private:
    static constexpr std::size_t kAlignment = 64;

    struct Block {
        HugePageMemory memory;
        std::uint64_t bytes = 0;
    };

    std::byte* take_bytes(std::uint64_t bytes);

    mutable std::mutex mutex_;
    std::vector<Block> blocks_;         // the last one is in use
    std::uint64_t used_in_last_ = 0;    // bytes
    std::uint64_t used_in_others_ = 0;  // bytes
};

}  // namespace clbvh
