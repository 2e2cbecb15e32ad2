// The stage `sort` against std::stable_sort, on keys that are hard on a radix sort.
#include "device/radix_sort.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <numeric>

#include "device/stage_bench.hpp"
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

void upload_codes(const device::BuildBuffers& buffers, const Codes& codes) {
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

BuildOptions sort_options(Shape shape) {
    BuildOptions options = options_of(shape);
    options.sort_shape = shape;
    return options;
}

/// Sorts on `bench`, which may have room for more, and compares.
void expect_stable_order(StageBench& bench, const Codes& codes) {
    std::vector<std::uint32_t> order(codes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return codes[i]; });
    Codes sorted;
    for (const std::uint32_t i : order)
        sorted.push_back(codes[i]);

    upload_codes(bench.buffers, codes);
    device::launch_radix_sort(bench.launcher, bench.settings, bench.buffers, static_cast<std::uint32_t>(codes.size()));
    const bool same_order = read<std::uint32_t>(bench.buffers.primitive_ids, codes.size()) == order;
    const bool same_codes = read<std::uint64_t>(bench.buffers.codes, codes.size()) == sorted;
    CHECK(same_order);
    CHECK(same_codes);
}

void expect_stable_order(const std::vector<KeyPattern>& patterns, const std::vector<std::uint32_t>& sizes) {
    for (const Shape shape : kBothShapes) {
        StageBench bench(settings_of(sort_options(shape)), std::ranges::max(sizes));
        for (const std::uint32_t size : sizes) {
            for (const KeyPattern& pattern : patterns) {
                INFO(to_string(shape) << ", " << size << " pairs: " << pattern.name);
                expect_stable_order(bench, make_codes(pattern, size));
            }
        }
    }
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
    for (const Shape shape : kBothShapes) {
        StageBench bench(settings_of(sort_options(shape)), 100);
        fill_bytes(bench.buffers.primitive_ids, 0x5a);
        expect_stable_order(bench, {});
        CHECK(read<std::uint32_t>(bench.buffers.primitive_ids, 100) == std::vector<std::uint32_t>(100, 0x5a5a5a5a));
    }
}

TEST_CASE("sort: small work groups, and as many pieces as a large device takes") {
    for (const KeyPattern& pattern : key_patterns()) {
        INFO(pattern.name);
        for (const std::size_t largest_group : {32, 64, 128}) {
            StageBench bench(small_group_settings(sort_options(Shape::group), largest_group), 9000);
            expect_stable_order(bench, make_codes(pattern, 9000));
        }
        for (const Shape shape : kBothShapes) {
            StageBench bench(large_device_settings(sort_options(shape)), 50000);
            expect_stable_order(bench, make_codes(pattern, 50000));
        }
    }
    StageBench most_pieces(large_device_settings(sort_options(Shape::group)), 1025 * 1024);
    expect_stable_order(most_pieces, make_codes(key_patterns().front(), 1025 * 1024));
}
