#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "measure/native_sort.hpp"

using clbvh::tool::NativeSort;

namespace {

void expect_same_as_stable_sort(NativeSort& sort, std::vector<std::uint64_t> keys) {
    std::vector<std::uint32_t> values(keys.size());
    std::iota(values.begin(), values.end(), 0u);
    std::vector<std::uint32_t> expected_values = values;
    std::stable_sort(expected_values.begin(), expected_values.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    std::vector<std::uint64_t> expected_keys = keys;
    std::sort(expected_keys.begin(), expected_keys.end());
    sort.sort(keys, values);
    CHECK(keys == expected_keys);
    CHECK(values == expected_values);
}

}  // namespace

TEST_CASE("the native sort equals std::stable_sort") {
    std::mt19937_64 random;
    NativeSort sort(50000);
    for (const std::size_t count : {0u, 1u, 2u, 3u, 2047u, 2048u, 2049u, 50000u}) {
        INFO(count);
        std::vector<std::uint64_t> keys(count);
        std::generate(keys.begin(), keys.end(), [&] { return random(); });
        expect_same_as_stable_sort(sort, keys);
        std::generate(keys.begin(), keys.end(), [&] { return random() % 5 << 61; });
        expect_same_as_stable_sort(sort, keys);
    }
}
