#include "measure/native_sort.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

namespace clbvh::tool {
namespace {

constexpr unsigned kDigitBits = 11;
constexpr unsigned kPasses = 6;  // An even number: the last pass ends in the caller's memory.
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
static_assert(kDigitBits * kPasses >= 64 && kPasses % 2 == 0);

struct Arrays {
    std::span<std::uint64_t> keys;
    std::span<std::uint32_t> values;
};

std::size_t digit(std::uint64_t key, unsigned shift) {
    return (key >> shift) % kDigits;
}

/// Calls work(offsets of this part, begin, end) for each thread's part of `count` keys.
template <typename Work>
void for_each_part(std::size_t count, std::size_t parts, std::span<std::uint32_t> offsets, const Work& work) {
    tbb::parallel_for(
        std::size_t{0}, parts,
        [&](std::size_t part) {
            work(offsets.subspan(part * kDigits, kDigits), count * part / parts, count * (part + 1) / parts);
        },
        tbb::static_partitioner{});
}

void counts_to_offsets(std::span<std::uint32_t> offsets, std::size_t parts) {
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < kDigits; ++d) {
        for (std::size_t part = 0; part < parts; ++part) {
            sum += std::exchange(offsets[part * kDigits + d], sum);
        }
    }
}

void sort_by_digit(const Arrays& from, const Arrays& to, unsigned shift, std::span<std::uint32_t> offsets,
                   std::size_t parts) {
    const std::size_t count = from.keys.size();
    for_each_part(count, parts, offsets, [&](std::span<std::uint32_t> counts, std::size_t begin, std::size_t end) {
        std::fill(counts.begin(), counts.end(), 0u);
        for (std::size_t i = begin; i < end; ++i)
            ++counts[digit(from.keys[i], shift)];
    });
    counts_to_offsets(offsets, parts);
    for_each_part(count, parts, offsets, [&](std::span<std::uint32_t> next, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t position = next[digit(from.keys[i], shift)]++;
            to.keys[position] = from.keys[i];
            to.values[position] = from.values[i];
        }
    });
}

}  // namespace

NativeSort::NativeSort(std::size_t capacity) : keys_(capacity), values_(capacity), offsets_(threads() * kDigits) {}

std::size_t NativeSort::threads() {
    return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
}

void NativeSort::sort(std::span<std::uint64_t> keys, std::span<std::uint32_t> values) {
    Arrays from{keys, values};
    const std::size_t parts = offsets_.size() / kDigits;
    Arrays to{std::span(keys_).first(keys.size()), std::span(values_).first(keys.size())};
    for (unsigned pass = 0; pass < kPasses; ++pass) {
        sort_by_digit(from, to, pass * kDigitBits, offsets_, parts);
        std::swap(from, to);
    }
}

}  // namespace clbvh::tool
