#include "clbvh/core/build_options.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <sstream>
#include <string>

#include "clbvh/core/error.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using clbvh::test::expect_error;

namespace {

using Change = std::function<void(BuildOptions&)>;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string text_of(float value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

void expect_accepted(const Change& change) {
    BuildOptions options;
    change(options);
    CHECK_NOTHROW(check_options(options));
}

void expect_message(const std::string& message, const Change& change) {
    BuildOptions options;
    change(options);
    expect_error(ErrorCode::invalid_input, {message}, [&] { check_options(options); });
}

void expect_rejected(const std::string& name, std::uint32_t value, const Change& change) {
    expect_message(name + " is " + std::to_string(value) + "; it must be ", change);
}

template <typename Enum, typename FromName>
void expect_round_trip(Enum value, const char* name, FromName from_name) {
    CHECK(to_string(value) == name);
    CHECK(from_name(name) == value);
}

}  // namespace

TEST_CASE("the defaults are valid options") {
    CHECK_NOTHROW(check_options({}));
}

TEST_CASE("options are accepted up to the ends of their ranges") {
    for (const std::uint32_t radius : {1u, 2u, 31u, 32u}) {
        expect_accepted([&](BuildOptions& o) { o.search_radius = radius; });
    }
    for (const std::uint32_t threshold : {0u, 2u, 1u << 20}) {
        expect_accepted([&](BuildOptions& o) { o.single_group_threshold = threshold; });
    }
    for (const std::uint32_t chunk : {0u, 64u, 128u, 192u, 4096u}) {
        expect_accepted([&](BuildOptions& o) { o.chunk_size = chunk; });
    }
    for (const std::uint32_t size : {0u, 32u, 64u, 1024u}) {
        expect_accepted([&](BuildOptions& o) { o.work_group_size = size; });
    }
    for (const std::uint32_t count : {0u, 1u, 512u}) {
        expect_accepted([&](BuildOptions& o) { o.range_count = count; });
    }
    for (const std::uint32_t bits : {0u, 33u, 44u, 63u}) {
        expect_accepted([&](BuildOptions& o) { o.code_bits = bits; });
    }
}

TEST_CASE("options beyond their ranges are rejected by name and value") {
    for (const std::uint32_t radius : {0u, 33u, ~0u}) {
        expect_rejected("search_radius", radius, [&](BuildOptions& o) { o.search_radius = radius; });
    }
    for (const std::uint32_t threshold : {1u, (1u << 20) + 1}) {
        expect_rejected("single_group_threshold", threshold,
                        [&](BuildOptions& o) { o.single_group_threshold = threshold; });
    }
    for (const std::uint32_t chunk : {1u, 63u, 65u, 4095u, 4160u}) {
        expect_rejected("chunk_size", chunk, [&](BuildOptions& o) { o.chunk_size = chunk; });
    }
    for (const std::uint32_t size : {1u, 16u, 48u, 1023u, 2048u}) {
        expect_rejected("work_group_size", size, [&](BuildOptions& o) { o.work_group_size = size; });
    }
    for (const std::uint32_t count : {513u, ~0u}) {
        expect_rejected("range_count", count, [&](BuildOptions& o) { o.range_count = count; });
    }
    for (const std::uint32_t bits : {1u, 32u, 43u, 64u}) {
        expect_rejected("code_bits", bits, [&](BuildOptions& o) { o.code_bits = bits; });
    }
}

TEST_CASE("options of H-PLOC are accepted and rejected at the ends of their ranges") {
    for (const std::uint32_t limit : {0u, 8u, 16u})
        expect_accepted([&](BuildOptions& o) { o.cluster_limit = limit; });
    for (const std::uint32_t limit : {1u, 7u, 9u, 15u, 17u, 32u})
        expect_rejected("cluster_limit", limit, [&](BuildOptions& o) { o.cluster_limit = limit; });
    for (const std::uint32_t range : {0u, 1u, 1u << 30})
        expect_accepted([&](BuildOptions& o) { o.small_range = range; });
    expect_rejected("small_range", (1u << 30) + 1, [](BuildOptions& o) { o.small_range = (1u << 30) + 1; });
    for (const std::uint32_t limit : {0u, 1u, 8u})
        expect_accepted([&](BuildOptions& o) { o.small_limit = limit; });
    expect_rejected("small_limit", 9, [](BuildOptions& o) { o.small_limit = 9; });
}

TEST_CASE("options of the host's builders and stages are accepted up to the ends of their ranges") {
    for (const std::uint32_t size : {0u, 1u, 64u}) {
        expect_accepted([&](BuildOptions& o) { o.max_leaf_size = size; });
    }
    for (const std::uint32_t count : {2u, 64u}) {
        expect_accepted([&](BuildOptions& o) { o.bin_count = count; });
    }
    for (const std::uint32_t level : {0u, 1u, 40u}) {
        expect_accepted([&](BuildOptions& o) { o.presplit_level = level; });
    }
    for (const std::uint32_t count : {0u, 1u, 1024u}) {
        expect_accepted([&](BuildOptions& o) { o.thread_count = count; });
    }
    for (const float alpha : {0.0f, 1.0f}) {
        expect_accepted([&](BuildOptions& o) { o.split_alpha = alpha; });
    }
    for (const float budget : {1.0f, 8.0f}) {
        expect_accepted([&](BuildOptions& o) { o.reference_budget = budget; });
    }
    expect_accepted([](BuildOptions& o) { o.inner_cost = o.primitive_cost = std::numeric_limits<float>::min(); });
}

TEST_CASE("options of the host's builders and stages are rejected with their range") {
    for (const float cost : {0.0f, -1.0f, kInfinity, kNan}) {
        expect_message("inner_cost is " + text_of(cost) + "; it must be finite and above 0",
                       [&](BuildOptions& o) { o.inner_cost = cost; });
        expect_message("primitive_cost is " + text_of(cost) + "; it must be finite and above 0",
                       [&](BuildOptions& o) { o.primitive_cost = cost; });
    }
    expect_message("max_leaf_size is 65; it must be 0 to 64", [](BuildOptions& o) { o.max_leaf_size = 65; });
    for (const std::uint32_t count : {0u, 1u, 65u}) {
        expect_message("bin_count is " + std::to_string(count) + "; it must be 2 to 64",
                       [&](BuildOptions& o) { o.bin_count = count; });
    }
    for (const float alpha : {-0.5f, 1.5f, kNan}) {
        expect_message("split_alpha is " + text_of(alpha) + "; it must be 0 to 1",
                       [&](BuildOptions& o) { o.split_alpha = alpha; });
    }
    for (const float budget : {0.5f, 8.5f, kInfinity, kNan}) {
        expect_message("reference_budget is " + text_of(budget) + "; it must be 1 to 8",
                       [&](BuildOptions& o) { o.reference_budget = budget; });
    }
    expect_message("presplit_level is 41; it must be 0 to 40", [](BuildOptions& o) { o.presplit_level = 41; });
    expect_message("thread_count is 1025; it must be 0 to 1024", [](BuildOptions& o) { o.thread_count = 1025; });
}

TEST_CASE("values that are no enumerators are rejected") {
    expect_rejected("shape", 3, [](BuildOptions& o) { o.shape = static_cast<Shape>(3); });
    expect_rejected("morton_code", 2, [](BuildOptions& o) { o.morton_code = static_cast<MortonCode>(2); });
    expect_rejected("neighbour_encoding", 9,
                    [](BuildOptions& o) { o.neighbour_encoding = static_cast<NeighbourEncoding>(9); });
    expect_rejected("neighbour_search", 255,
                    [](BuildOptions& o) { o.neighbour_search = static_cast<NeighbourSearch>(255); });
    expect_rejected("hploc_quality", 2, [](BuildOptions& o) { o.hploc_quality = static_cast<HplocQuality>(2); });
    expect_rejected("hploc_search", 3, [](BuildOptions& o) { o.hploc_search = static_cast<HplocSearch>(3); });
    expect_rejected("optimize_on", 2, [](BuildOptions& o) { o.optimize_on = static_cast<OptimizeOn>(2); });
    expect_rejected("merge_pairs", 3, [](BuildOptions& o) { o.merge_pairs = static_cast<PairMerging>(3); });
}

TEST_CASE("the first option out of its range is named") {
    expect_rejected("search_radius", 0, [](BuildOptions& o) {
        o.search_radius = 0;
        o.range_count = 1000;
    });
}

TEST_CASE("names of options' values lead back to the values") {
    expect_round_trip(Shape::automatic, "auto", shape_from);
    expect_round_trip(Shape::group, "group", shape_from);
    expect_round_trip(Shape::lane, "lane", shape_from);
    expect_round_trip(MortonCode::xyz, "xyz", morton_code_from);
    expect_round_trip(MortonCode::extended, "extended", morton_code_from);
    expect_round_trip(NeighbourEncoding::automatic, "auto", neighbour_encoding_from);
    expect_round_trip(NeighbourEncoding::bits32, "bits32", neighbour_encoding_from);
    expect_round_trip(NeighbourEncoding::bits64, "bits64", neighbour_encoding_from);
    expect_round_trip(NeighbourSearch::automatic, "auto", neighbour_search_from);
    expect_round_trip(NeighbourSearch::symmetric, "symmetric", neighbour_search_from);
    expect_round_trip(NeighbourSearch::scan, "scan", neighbour_search_from);
    expect_round_trip(HplocQuality::balanced, "balanced", hploc_quality_from);
    expect_round_trip(HplocQuality::fast, "fast", hploc_quality_from);
    expect_round_trip(HplocSearch::automatic, "auto", hploc_search_from);
    expect_round_trip(HplocSearch::all_pairs, "all-pairs", hploc_search_from);
    expect_round_trip(HplocSearch::window, "window", hploc_search_from);
    expect_round_trip(PairMerging::automatic, "auto", pair_merging_from);
    expect_round_trip(PairMerging::on, "on", pair_merging_from);
    expect_round_trip(PairMerging::off, "off", pair_merging_from);
    expect_round_trip(OptimizeOn::host, "host", optimize_on_from);
    expect_round_trip(OptimizeOn::device, "device", optimize_on_from);
}

TEST_CASE("unknown names lead to nothing") {
    for (const char* name : {"", "Group", "group ", "automatic", "bits", "64"}) {
        INFO(name);
        CHECK_FALSE(shape_from(name));
        CHECK_FALSE(morton_code_from(name));
        CHECK_FALSE(neighbour_encoding_from(name));
        CHECK_FALSE(neighbour_search_from(name));
        CHECK_FALSE(hploc_quality_from(name));
        CHECK_FALSE(hploc_search_from(name));
        CHECK_FALSE(pair_merging_from(name));
        CHECK_FALSE(optimize_on_from(name));
    }
}
