#pragma once

#include <cstdint>
#include <span>

#include "core/scratch.hpp"

namespace clbvh::host {

/// Keys, and the value that belongs to each: two arrays of one size.
template <typename Key>
struct KeyedValues {
    std::span<Key> keys;
    std::span<std::uint32_t> values;
};

/// Sorts by the low `key_bits` bits of the keys, whose other bits are 0; stable, so that the result is the same on any
/// number of threads. `other` is memory of the same size to work in. Returns the one of the two that holds the result;
/// the other one holds anything. O(n) for a fixed number of bits, 11 bits a pass. Key is std::uint32_t or
/// std::uint64_t.
template <typename Key>
[[nodiscard]] KeyedValues<Key> radix_sort(KeyedValues<Key> input, KeyedValues<Key> other, std::uint32_t key_bits,
                                          Scratch& scratch);

}  // namespace clbvh::host
