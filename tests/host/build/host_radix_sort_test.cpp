#include "host/build/radix_sort.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <vector>

using namespace clbvh::host;

namespace {

template <typename Key>
struct Pairs {
    std::vector<Key> keys;
    std::vector<std::uint32_t> values;

    friend bool operator==(const Pairs&, const Pairs&) = default;
};

/// Keys of `key_bits` bits of which only `distinct` different ones occur.
template <typename Key>
Pairs<Key> make_pairs(std::size_t count, std::uint32_t key_bits, std::uint32_t distinct) {
    std::mt19937_64 random(count * 67 + key_bits);
    const Key mask = key_bits == sizeof(Key) * 8 ? ~Key{0} : (Key{1} << key_bits) - 1;
    std::vector<Key> choice(distinct);
    for (Key& key : choice)
        key = static_cast<Key>(random()) & mask;
    Pairs<Key> pairs{std::vector<Key>(count), std::vector<std::uint32_t>(count)};
    for (Key& key : pairs.keys)
        key = choice[random() % distinct];
    for (std::uint32_t& value : pairs.values)
        value = static_cast<std::uint32_t>(random());
    return pairs;
}

template <typename Key>
Pairs<Key> stable_sorted(const Pairs<Key>& pairs) {
    std::vector<std::size_t> order(pairs.keys.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return pairs.keys[i]; });
    Pairs<Key> sorted;
    for (const std::size_t i : order) {
        sorted.keys.push_back(pairs.keys[i]);
        sorted.values.push_back(pairs.values[i]);
    }
    return sorted;
}

template <typename Key>
Pairs<Key> radix_sorted(Pairs<Key> pairs, std::uint32_t key_bits) {
    clbvh::Scratch scratch;
    Pairs<Key> other = pairs;
    const KeyedValues<Key> sorted =
        radix_sort<Key>({pairs.keys, pairs.values}, {other.keys, other.values}, key_bits, scratch);
    return {{sorted.keys.begin(), sorted.keys.end()}, {sorted.values.begin(), sorted.values.end()}};
}

}  // namespace

TEMPLATE_TEST_CASE("the radix sort is a stable sort", "[host][radix_sort]", std::uint32_t, std::uint64_t) {
    const std::size_t count = GENERATE(0u, 1u, 2u, 3u, 1000u, 16383u, 16385u, 100'000u);
    const std::uint32_t key_bits = GENERATE(1u, 3u, 8u, 11u, 12u, 22u, 30u, 32u, 33u, 63u, 64u);
    if (key_bits > sizeof(TestType) * 8) return;
    const std::uint32_t distinct = GENERATE(1u, 3u, 1u << 20);
    const Pairs<TestType> pairs = make_pairs<TestType>(count, key_bits, distinct);
    INFO(count << " keys of " << key_bits << " bits, " << distinct << " different ones at most");
    CHECK((radix_sorted(pairs, key_bits) == stable_sorted(pairs)));
}

TEST_CASE("the radix sort leaves the result where it says", "[host][radix_sort]") {
    const std::uint32_t key_bits = GENERATE(0u, 11u, 22u, 30u, 32u);
    const Pairs<std::uint32_t> pairs = make_pairs<std::uint32_t>(50'000, key_bits, 1u << 20);
    Pairs<std::uint32_t> input = pairs;
    Pairs<std::uint32_t> other = pairs;
    clbvh::Scratch scratch;
    const KeyedValues<std::uint32_t> sorted =
        radix_sort<std::uint32_t>({input.keys, input.values}, {other.keys, other.values}, key_bits, scratch);
    const Pairs<std::uint32_t> expected = stable_sorted(pairs);
    CHECK(std::ranges::equal(sorted.keys, expected.keys));
    CHECK(std::ranges::equal(sorted.values, expected.values));
}

TEST_CASE("the radix sort needs no second thread", "[host][radix_sort]") {
    const Pairs<std::uint64_t> pairs = make_pairs<std::uint64_t>(300'000, 45, 1u << 20);
    Pairs<std::uint64_t> alone;
    tbb::task_arena(1).execute([&] { alone = radix_sorted(pairs, 45); });
    CHECK((alone == radix_sorted(pairs, 45)));
}
