// Least significant digit first radix sort. Gu et al. 2013, section 3.4.1: blocks of the input count and scatter in
// parallel, each with buckets of its own.
#include "host/build/radix_sort.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/simd/prefetch.hpp"

namespace clbvh::host {
namespace {

/// Inputs from this size on have buckets enough for the digits of kWideDigit bits.
constexpr std::size_t kWideInput = std::size_t{1} << 15;
constexpr std::uint32_t kWideDigit = 11;
constexpr std::uint32_t kNarrowDigit = 8;

constexpr std::size_t kLeastBlock = std::size_t{1} << 14;
constexpr std::size_t kMostBlocks = 64;

/// Elements ahead of the one at work that are asked for.
constexpr std::size_t kPrefetch = 256;

template <typename Key>
class RadixSorter {
public:
    RadixSorter(std::size_t count, std::uint32_t key_bits, Scratch& scratch)
        : count_(count),
          block_size_(std::max(kLeastBlock, (count + kMostBlocks - 1) / kMostBlocks)),
          block_count_((count + block_size_ - 1) / block_size_) {
        const std::uint32_t widest = count < kWideInput ? kNarrowDigit : kWideDigit;
        const std::uint32_t passes = (key_bits + widest - 1) / widest;
        digit_bits_ = (key_bits + passes - 1) / passes;
        next_ = scratch.take<std::uint32_t>(block_count_ << digit_bits_);
    }

    [[nodiscard]] std::uint32_t digit_bits() const noexcept { return digit_bits_; }

    /// Sorts by the digit that begins at bit `shift`. False where all keys have the same one: then nothing was moved.
    bool sort_digit(const KeyedValues<Key>& from, const KeyedValues<Key>& to, std::uint32_t shift) {
        for_each_block([&](std::size_t block) { count_digits(from, block, shift); });
        if (!place_buckets()) return false;
        for_each_block([&](std::size_t block) { scatter(from, to, block, shift); });
        return true;
    }

private:
    template <typename Work>
    void for_each_block(const Work& work) const {
        if (block_count_ == 1) return work(0);
        tbb::parallel_for(std::size_t{0}, block_count_, work);
    }

    [[nodiscard]] std::uint32_t digit_of(Key key, std::uint32_t shift) const noexcept {
        return static_cast<std::uint32_t>(key >> shift) & ((1u << digit_bits_) - 1);
    }
    [[nodiscard]] std::span<std::uint32_t> buckets(std::size_t block) const noexcept {
        return next_.subspan(block << digit_bits_, std::size_t{1} << digit_bits_);
    }
    [[nodiscard]] std::size_t end_of(std::size_t block) const noexcept {
        return std::min(count_, (block + 1) * block_size_);
    }

    void count_digits(const KeyedValues<Key>& from, std::size_t block, std::uint32_t shift) const noexcept {
        const std::span<std::uint32_t> counts = buckets(block);
        std::ranges::fill(counts, 0u);
        for (std::size_t i = block * block_size_; i < end_of(block); ++i) {
            prefetch(from.keys.data() + i + kPrefetch);
            ++counts[digit_of(from.keys[i], shift)];
        }
    }

    /// Turns counts into the place of each block's next element of each bucket.
    bool place_buckets() const noexcept {
        std::uint32_t start[1u << kWideDigit] = {};
        const std::size_t bucket_count = std::size_t{1} << digit_bits_;
        for (std::size_t block = 0; block < block_count_; ++block)
            for (std::size_t bucket = 0; bucket < bucket_count; ++bucket)
                start[bucket] += buckets(block)[bucket];
        std::uint32_t before = 0;
        for (std::size_t bucket = 0; bucket < bucket_count; ++bucket) {
            const std::uint32_t size = start[bucket];
            if (size == count_) return false;
            start[bucket] = before;
            before += size;
        }
        for (std::size_t block = 0; block < block_count_; ++block) {
            const std::span<std::uint32_t> next = buckets(block);
            for (std::size_t bucket = 0; bucket < bucket_count; ++bucket) {
                const std::uint32_t size = next[bucket];
                next[bucket] = start[bucket];
                start[bucket] += size;
            }
        }
        return true;
    }

    void scatter(const KeyedValues<Key>& from, const KeyedValues<Key>& to, std::size_t block,
                 std::uint32_t shift) const noexcept {
        const std::span<std::uint32_t> next = buckets(block);
        for (std::size_t i = block * block_size_; i < end_of(block); ++i) {
            prefetch(from.keys.data() + i + kPrefetch);
            prefetch(from.values.data() + i + kPrefetch);
            const Key key = from.keys[i];
            const std::uint32_t place = next[digit_of(key, shift)]++;
            to.keys[place] = key;
            to.values[place] = from.values[i];
        }
    }

    std::size_t count_;
    std::size_t block_size_;
    std::size_t block_count_;
    std::uint32_t digit_bits_ = 0;
    std::span<std::uint32_t> next_;  // for each block, for each bucket
};

}  // namespace

template <typename Key>
KeyedValues<Key> radix_sort(KeyedValues<Key> input, KeyedValues<Key> other, std::uint32_t key_bits, Scratch& scratch) {
    if (input.keys.size() <= 1 || key_bits == 0) return input;
    RadixSorter<Key> sorter(input.keys.size(), key_bits, scratch);
    for (std::uint32_t shift = 0; shift < key_bits; shift += sorter.digit_bits()) {
        if (sorter.sort_digit(input, other, shift)) std::swap(input, other);
    }
    return input;
}

template KeyedValues<std::uint32_t> radix_sort(KeyedValues<std::uint32_t>, KeyedValues<std::uint32_t>, std::uint32_t,
                                               Scratch&);
template KeyedValues<std::uint64_t> radix_sort(KeyedValues<std::uint64_t>, KeyedValues<std::uint64_t>, std::uint32_t,
                                               Scratch&);

}  // namespace clbvh::host
