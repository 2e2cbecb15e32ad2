// The stage `sort` against std::stable_sort, on keys that are hard on a radix sort.
#include "device/build/radix_sort.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <numeric>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Codes = std::vector<std::uint64_t>;

struct Pair {
    std::uint32_t key;
    std::uint32_t primitive;
};

/// The code of primitive i of n.
struct KeyPattern {
    std::string name;
    std::function<std::uint64_t(std::uint32_t i, std::uint32_t n)> code;
};

constexpr std::uint64_t kInactiveKey = ~std::uint64_t{0};

/// Scrambles the bits of `i` (SplitMix64).
std::uint64_t scrambled(std::uint64_t i) {
    i = (i + 1) * 0x9e3779b97f4a7c15;
    i = (i ^ i >> 30) * 0xbf58476d1ce4e5b9;
    i = (i ^ i >> 27) * 0x94d049bb133111eb;
    return i ^ i >> 31;
}

std::vector<KeyPattern> key_patterns() {
    std::vector<KeyPattern> patterns{
        {"all zero", [](auto, auto) { return std::uint64_t{0}; }},
        {"all equal", [](auto, auto) { return std::uint64_t{0x123456789abcdef0}; }},
        {"all ones", [](auto, auto) { return kInactiveKey; }},
        {"sorted", [](auto i, auto) { return std::uint64_t{i} << 25; }},
        {"reversed", [](auto i, auto n) { return std::uint64_t{n - i} << 25; }},
        {"two values in turn", [](auto i, auto) { return i % 2 == 0 ? std::uint64_t{1} << 62 : std::uint64_t{1}; }},
        {"one smaller at the end", [](auto i, auto n) { return std::uint64_t{i + 1 == n ? 1u : 2u} << 40; }},
        {"halves against each other", [](auto i, auto n) { return std::uint64_t{i} << 32 | (n - i); }},
        {"random", [](auto i, auto) { return scrambled(i) >> 1; }},
        {"random with many ties", [](auto i, auto) { return scrambled(i) & 0x0300030003000300; }},
        {"each third inactive", [](auto i, auto) { return i % 3 == 0 ? kInactiveKey : scrambled(i) >> 1; }},
    };
    for (std::uint32_t digit = 0; digit < 8; ++digit) {
        patterns.push_back({"only digit " + std::to_string(digit), [digit](auto i, auto) {
                                return (scrambled(i) & 255) << 8 * digit |
                                       (std::uint64_t{0x55} << (8 * digit + 32) % 64);
                            }});
    }
    return patterns;
}

Codes make_codes(const KeyPattern& pattern, std::uint32_t size) {
    Codes codes;
    for (std::uint32_t i = 0; i < size; ++i)
        codes.push_back(pattern.code(i, size));
    return codes;
}

void upload_pairs(const device::BuildBuffers& buffers, const Codes& codes) {
    std::vector<Pair> pairs;
    std::vector<std::uint32_t> low, high;
    for (std::uint32_t i = 0; i < codes.size(); ++i) {
        low.push_back(static_cast<std::uint32_t>(codes[i]));
        high.push_back(static_cast<std::uint32_t>(codes[i] >> 32));
        pairs.push_back({low.back(), i});
    }
    write(buffers.pairs_a, pairs);
    write(buffers.code_low, low);
    write(buffers.code_high, high);
}

BuildOptions sort_options(Shape shape, std::uint32_t code_bits) {
    BuildOptions options = options_of(shape);
    options.device.sort_shape = shape;
    options.device.code_bits = code_bits;
    return options;
}

/// The leading bits of `code`, above the index.
std::uint64_t packed_key(std::uint64_t code, std::uint64_t i, const device::KeyLayout& layout) {
    return code >> (64 - layout.code_bits) << layout.index_bits | i;
}

/// Sorts on `bench`, which may have room for more, and compares.
void expect_stable_order(StageBench& bench, const Codes& codes) {
    const auto size = static_cast<std::uint32_t>(codes.size());
    Codes keys = codes;
    if (bench.settings.packed_keys()) {
        for (std::uint32_t i = 0; i < size; ++i)
            keys[i] = packed_key(codes[i], i, bench.settings.key_layout(size));
        write(device::unsorted_keys(bench.settings, bench.buffers, size), keys);
        device::launch_count_keys(bench.launcher, bench.settings, bench.buffers, size);
    } else {
        upload_pairs(bench.buffers, codes);
    }
    std::vector<std::uint32_t> order(codes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return keys[i]; });
    Codes sorted;
    for (const std::uint32_t i : order)
        sorted.push_back(keys[i]);

    device::launch_radix_sort(bench.launcher, bench.settings, bench.buffers, size);
    const bool same_order = read<std::uint32_t>(bench.buffers.primitive_ids, codes.size()) == order;
    const bool same_keys = read<std::uint64_t>(bench.buffers.codes, codes.size()) == sorted;
    CHECK(same_order);
    CHECK(same_keys);
}

/// Calls `check` with options of both shapes, for packed keys and for pairs.
template <typename Check>
void for_each_sort(Check check) {
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t code_bits : {33u, 44u, 63u}) {
            INFO(to_string(shape) << ", code_bits " << code_bits);
            check(sort_options(shape, code_bits));
        }
    }
}

void expect_stable_order(const std::vector<KeyPattern>& patterns, const std::vector<std::uint32_t>& sizes) {
    for_each_sort([&](const BuildOptions& options) {
        StageBench bench(settings_of(options), std::ranges::max(sizes));
        for (const std::uint32_t size : sizes) {
            for (const KeyPattern& pattern : patterns) {
                INFO(size << " elements: " << pattern.name);
                expect_stable_order(bench, make_codes(pattern, size));
            }
        }
    });
}

}  // namespace

TEST_CASE("sort: hard keys at sizes around work groups and tiles") {
    expect_stable_order(key_patterns(), {1, 2, 3, 255, 256, 257, 1023, 1024, 1025, 4095, 4096, 4097});
}

TEST_CASE("sort: hard keys in many pieces") {
    expect_stable_order(key_patterns(), {100000});
}

TEST_CASE("sort: sizes around the number of pieces times a tile") {
    const std::vector<KeyPattern> patterns = key_patterns();
    const auto random = std::ranges::find(patterns, "random with many ties", &KeyPattern::name);
    REQUIRE(random != patterns.end());
    std::vector<std::uint32_t> sizes;
    for (const std::uint32_t tiles : {8u, 16u, 32u, 64u}) {
        for (const std::uint32_t size : {tiles * 1024 - 1, tiles * 1024, tiles * 1024 + 1})
            sizes.push_back(size);
    }
    expect_stable_order({*random}, sizes);
}

TEST_CASE("sort: nothing to sort leaves the results alone") {
    for_each_sort([](const BuildOptions& options) {
        StageBench bench(settings_of(options), 100);
        fill_bytes(bench.buffers.primitive_ids, 0x5a);
        expect_stable_order(bench, {});
        CHECK(read<std::uint32_t>(bench.buffers.primitive_ids, 100) == std::vector<std::uint32_t>(100, 0x5a5a5a5a));
    });
}

TEST_CASE("sort: small work groups, and as many pieces as a large device takes") {
    for (const KeyPattern& pattern : key_patterns()) {
        INFO(pattern.name);
        const Codes codes = make_codes(pattern, 50000);
        for_each_sort([&](const BuildOptions& options) {
            StageBench bench(large_device_settings(options), codes.size());
            expect_stable_order(bench, codes);
        });
        for (const std::uint32_t code_bits : {44u, 63u}) {
            for (const std::size_t largest_group : {32u, 64u, 128u}) {
                StageBench bench(small_group_settings(sort_options(Shape::group, code_bits), largest_group), 9000);
                expect_stable_order(bench, make_codes(pattern, 9000));
            }
        }
    }
    const Codes codes = make_codes(key_patterns().front(), 1025 * 1024);
    for (const std::uint32_t code_bits : {44u, 63u}) {
        StageBench most_pieces(large_device_settings(sort_options(Shape::group, code_bits)), codes.size());
        expect_stable_order(most_pieces, codes);
    }
}
