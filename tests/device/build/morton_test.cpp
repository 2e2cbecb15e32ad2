// The stage `morton` against the codes that the host puts together bit by bit.
#include "device/build/morton.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "device/build/radix_sort.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/oracle/morton_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint64_t kInactiveKey = ~std::uint64_t{0};

struct Pair {
    std::uint32_t key;
    std::uint32_t primitive;
};

/// A box, or none where the primitive is inactive.
using Boxes = std::vector<std::optional<Aabb>>;

/// Boxes with centres and sizes up to these along each axis.
Boxes random_boxes(std::size_t count, const Vec3& extent, const Vec3& size) {
    std::mt19937 random(5);
    const auto uniform = [&](float scale) { return static_cast<float>(random() >> 8) / 16777216.0f * scale; };
    Boxes boxes;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 lower{uniform(extent.x), uniform(extent.y), uniform(extent.z)};
        const Vec3 upper{lower.x + uniform(size.x), lower.y + uniform(size.y), lower.z + uniform(size.z)};
        boxes.push_back(Aabb{lower, upper});
    }
    return boxes;
}

std::vector<Aabb> active_boxes(const Boxes& boxes) {
    std::vector<Aabb> active;
    for (const std::optional<Aabb>& box : boxes) {
        if (box) active.push_back(*box);
    }
    return active;
}

std::vector<std::uint64_t> expected_codes(const Boxes& boxes, MortonCode code) {
    const std::vector<std::uint64_t> active = morton_codes(active_boxes(boxes), code);
    std::vector<std::uint64_t> codes;
    for (std::size_t i = 0, next = 0; i < boxes.size(); ++i)
        codes.push_back(boxes[i] ? active[next++] : kInactiveKey);
    return codes;
}

BuildOptions morton_options(MortonCode code, Shape shape, std::uint32_t code_bits) {
    BuildOptions options = options_of(shape);
    options.device.sort_shape = shape;
    options.device.morton_code = code;
    options.device.code_bits = code_bits;
    return options;
}

void launch_on(StageBench& bench, const Boxes& boxes) {
    const SceneBounds scene = scene_bounds(active_boxes(boxes));
    write(bench.buffers.bounds, std::vector<Aabb>{scene.primitives, scene.doubled_centroids});
    std::vector<Aabb> values;
    for (const std::optional<Aabb>& box : boxes)
        values.push_back(box.value_or(Aabb{{kNan, kNan, kNan}, {kNan, kNan, kNan}}));
    write(bench.buffers.boxes, values);
    device::launch_morton(bench.launcher, bench.settings, bench.buffers, static_cast<std::uint32_t>(boxes.size()));
}

/// The codes that launch_morton leaves for pairs, put together from their halves. Checks that the pairs agree.
std::vector<std::uint64_t> run_morton(const Boxes& boxes, const device::BuildSettings& settings) {
    StageBench bench(settings, boxes.size());
    launch_on(bench, boxes);
    const auto pairs = read<Pair>(bench.buffers.pairs_a, boxes.size());
    const auto low = read<std::uint32_t>(bench.buffers.code_low, boxes.size());
    const auto high = read<std::uint32_t>(bench.buffers.code_high, boxes.size());
    std::vector<std::uint64_t> codes;
    bool pairs_agree = true;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        codes.push_back(std::uint64_t{high[i]} << 32 | low[i]);
        pairs_agree = pairs_agree && pairs[i].key == low[i] && pairs[i].primitive == i;
    }
    CHECK(pairs_agree);
    return codes;
}

/// Of each piece of the sort, how many keys have which first digit: lane shape, piece by piece; group, digit by digit.
std::vector<std::uint32_t> first_digit_counts(const std::vector<std::uint64_t>& keys,
                                              const device::BuildSettings& settings) {
    const auto size = static_cast<std::uint32_t>(keys.size());
    const device::Pieces pieces = settings.sort_pieces(size);
    const std::uint32_t digits = 1u << settings.sort_digit_bits();
    std::vector<std::uint32_t> counts(digits * pieces.count);
    for (std::uint32_t i = 0; i < size; ++i) {
        const std::uint64_t digit = (keys[i] >> settings.key_layout(size).index_bits) % digits;
        const std::uint64_t piece = i / pieces.length;
        const bool lane = settings.sort_shape == Shape::lane;
        ++counts[lane ? piece * digits + digit : digit * pieces.count + piece];
    }
    return counts;
}

std::vector<std::uint64_t> expected_keys(const Boxes& boxes, const device::BuildSettings& settings) {
    const auto size = static_cast<std::uint32_t>(boxes.size());
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < size; ++i) {
        if (boxes[i]) ids.push_back(i);
    }
    const std::vector<std::uint64_t> active =
        packed_keys(morton_codes(active_boxes(boxes), settings.configs.device.morton_code), ids, size,
                    settings.configs.device.code_bits);
    const device::KeyLayout layout = settings.key_layout(size);
    std::vector<std::uint64_t> keys;
    for (std::uint64_t i = 0, next = 0; i < size; ++i) {
        const std::uint64_t inactive = ((std::uint64_t{1} << layout.code_bits) - 1) << layout.index_bits | i;
        keys.push_back(boxes[i] ? active[next++] : inactive);
    }
    return keys;
}

template <typename T>
std::ptrdiff_t same_values(const std::vector<T>& a, const std::vector<T>& b) {
    return std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin();
}

void expect_host_codes(const Boxes& boxes, const device::BuildSettings& settings, const std::string& where) {
    INFO(where << ", " << boxes.size() << " boxes, " << to_string(settings.configs.device.morton_code) << ", "
               << to_string(settings.shape) << ", code_bits " << settings.configs.device.code_bits);
    if (!settings.packed_keys()) {
        CHECK(same_values(expected_codes(boxes, settings.configs.device.morton_code), run_morton(boxes, settings)) ==
              static_cast<std::ptrdiff_t>(boxes.size()));
        return;
    }
    const auto size = static_cast<std::uint32_t>(boxes.size());
    const std::vector<std::uint64_t> keys = expected_keys(boxes, settings);
    const std::vector<std::uint32_t> counts = first_digit_counts(keys, settings);
    StageBench bench(settings, boxes.size());
    launch_on(bench, boxes);
    const auto launched = read<std::uint64_t>(device::unsorted_keys(settings, bench.buffers, size), boxes.size());
    CHECK(same_values(keys, launched) == static_cast<std::ptrdiff_t>(keys.size()));
    const auto counted = read<std::uint32_t>(bench.buffers.counts, counts.size());
    CHECK(same_values(counts, counted) == static_cast<std::ptrdiff_t>(counts.size()));
}

void expect_host_codes(const Boxes& boxes, const std::string& where) {
    for (const MortonCode code : {MortonCode::cubic, MortonCode::xyz, MortonCode::extended}) {
        for (const Shape shape : kBothShapes) {
            for (const std::uint32_t code_bits : {33u, 44u, 63u})
                expect_host_codes(boxes, settings_of(morton_options(code, shape, code_bits)), where);
        }
    }
}

Aabb point(float x, float y, float z) {
    return {{x, y, z}, {x, y, z}};
}

}  // namespace

TEST_CASE("morton: codes equal the host's at sizes around vectors, groups and pieces") {
    for (const std::size_t size :
         {1u, 2u, 15u, 16u, 17u, 31u, 32u, 33u, 255u, 256u, 257u, 1025u, 4095u, 4096u, 4097u, 30001u}) {
        expect_host_codes(random_boxes(size, {10, 20, 3}, {1, 1, 1}), "a box");
    }
}

TEST_CASE("morton: the corners of a cube have the codes that bits on paper give") {
    Boxes corners;
    for (std::uint32_t i = 0; i < 8; ++i)
        corners.push_back(point(static_cast<float>(i >> 2), static_cast<float>(i >> 1 & 1), static_cast<float>(i & 1)));
    constexpr std::uint64_t every_third = 0x1249249249249249;
    for (const Shape shape : kBothShapes) {
        const std::vector<std::uint64_t> codes =
            run_morton(corners, settings_of(morton_options(MortonCode::xyz, shape, 63)));
        for (std::uint64_t i = 0; i < 8; ++i)
            CHECK(codes[i] == i * every_third);
    }
}

TEST_CASE("morton: an inactive primitive has a key above every code, wherever it stands") {
    for (const std::size_t size : {2u, 16u, 33u, 300u, 5000u}) {
        for (const std::size_t step : {2u, 3u, 7u, 16u}) {
            Boxes boxes = random_boxes(size, {1, 1, 1}, {1, 1, 1});
            for (std::size_t i = step - 1; i < size; i += step)
                boxes[i].reset();
            expect_host_codes(boxes, "each of " + std::to_string(step) + " inactive");
        }
    }
    Boxes all_but_one(100);
    all_but_one[77] = Aabb{{1, 2, 3}, {4, 5, 6}};
    expect_host_codes(all_but_one, "one active");
}

TEST_CASE("morton: planes, lines and points have axes without an extent") {
    expect_host_codes(random_boxes(1000, {5, 0, 5}, {1, 0, 1}), "a plane");
    expect_host_codes(random_boxes(1000, {0, 5, 0}, {0, 1, 0}), "a line");
    expect_host_codes(random_boxes(1000, {0, 0, 0}, {0, 0, 0}), "a point");
    expect_host_codes(Boxes(1000, Aabb{{-1, -2, -3}, {1, 2, 3}}), "equal boxes");
}

TEST_CASE("morton: extents at the ends of the range of float") {
    expect_host_codes(random_boxes(1000, {9e17f, 9e17f, 9e17f}, {1e16f, 1e16f, 1e16f}), "huge");
    expect_host_codes(random_boxes(1000, {1e-36f, 1e-36f, 1e-36f}, {1e-37f, 1e-37f, 1e-37f}), "tiny");
    expect_host_codes(random_boxes(1000, {9e17f, 1.0f, 1e-30f}, {1, 1, 1}), "a needle");
    Boxes outliers = random_boxes(1000, {1, 1, 1}, {1, 1, 1});
    outliers[500] = point(-kMaxCoordinate, kMaxCoordinate, kMaxCoordinate);
    outliers[501] =
        Aabb{{-kMaxCoordinate, -kMaxCoordinate, -kMaxCoordinate}, {kMaxCoordinate, kMaxCoordinate, kMaxCoordinate}};
    expect_host_codes(outliers, "outliers");
}

TEST_CASE("morton: sizes from a point to the scene decide the extended code's size bits") {
    Boxes boxes;
    for (std::uint32_t i = 0; i < 600; ++i) {
        const float size = std::ldexp(1.0f, -static_cast<int>(i % 24));
        boxes.push_back(Aabb{{0.5f - size / 2, 0.5f - size / 2, 0.5f - size / 2},
                             {0.5f + size / 2, 0.5f + size / 2, 0.5f + size / 2}});
    }
    expect_host_codes(boxes, "concentric boxes");
    const std::vector<std::uint64_t> codes =
        run_morton(boxes, settings_of(morton_options(MortonCode::extended, Shape::lane, 63)));
    CHECK(codes[0] > codes[1]);
    CHECK(codes[1] > codes[2]);
}

TEST_CASE("morton: small work groups, and as many pieces as a large device takes") {
    for (const MortonCode code : {MortonCode::cubic, MortonCode::xyz, MortonCode::extended}) {
        for (const std::uint32_t code_bits : {44u, 63u}) {
            for (const Shape shape : kBothShapes) {
                const BuildOptions options = morton_options(code, shape, code_bits);
                expect_host_codes(random_boxes(300000, {1, 2, 3}, {1, 1, 1}), large_device_settings(options), "a box");
            }
            for (const std::size_t largest_group : {32u, 128u}) {
                const BuildOptions options = morton_options(code, Shape::group, code_bits);
                expect_host_codes(random_boxes(5000, {1, 2, 3}, {1, 1, 1}),
                                  small_group_settings(options, largest_group),
                                  "groups of " + std::to_string(largest_group));
            }
        }
    }
}
