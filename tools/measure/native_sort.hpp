#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clbvh::tool {

/// A plain radix sort on all hardware threads: what the builders' times are measured against.
///
/// Least significant digit first, six passes of 11 bits. Every thread counts the digits of its own contiguous part, the
/// counts are summed digit by digit, and every thread scatters its part: stable, and the same result on any number of
/// threads. Keeps its memory, so that repeated sorts touch none for the first time.
class NativeSort {
public:
    /// Sorts up to `capacity` keys.
    explicit NativeSort(std::size_t capacity);

    /// Sorts `keys` and carries `values` along; both have the same size.
    void sort(std::span<std::uint64_t> keys, std::span<std::uint32_t> values);

    /// How many threads a sort runs on.
    [[nodiscard]] static std::size_t threads();

private:
    std::vector<std::uint64_t> keys_;
    std::vector<std::uint32_t> values_;
    std::vector<std::uint32_t> offsets_;  ///< One table of digits per thread.
};

}  // namespace clbvh::tool
