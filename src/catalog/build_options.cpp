#include "clbvh/core/build_options.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/check_field.hpp"

namespace clbvh {
namespace {

template <typename Enum>
struct Named {
    Enum value;
    std::string_view name;
};
// clang 14 deduces no arguments of an aggregate by itself.
template <typename Enum>
Named(Enum, std::string_view) -> Named<Enum>;

constexpr std::array kShapes{
    Named{Shape::automatic, "auto"},
    Named{Shape::group, "group"},
    Named{Shape::lane, "lane"},
};
constexpr std::array kMortonCodes{
    Named{MortonCode::xyz, "xyz"},
    Named{MortonCode::extended, "extended"},
};
constexpr std::array kEncodings{
    Named{NeighbourEncoding::automatic, "auto"},
    Named{NeighbourEncoding::bits32, "bits32"},
    Named{NeighbourEncoding::bits64, "bits64"},
};
constexpr std::array kSearches{
    Named{NeighbourSearch::automatic, "auto"},
    Named{NeighbourSearch::symmetric, "symmetric"},
    Named{NeighbourSearch::scan, "scan"},
};
constexpr std::array kHplocQualities{
    Named{HplocQuality::balanced, "balanced"},
    Named{HplocQuality::fast, "fast"},
};
constexpr std::array kHplocSearches{
    Named{HplocSearch::automatic, "auto"},
    Named{HplocSearch::all_pairs, "all-pairs"},
    Named{HplocSearch::window, "window"},
};
constexpr std::array kPairMergings{
    Named{PairMerging::automatic, "auto"},
    Named{PairMerging::on, "on"},
    Named{PairMerging::off, "off"},
};

constexpr std::array kOptimizeOn{
    Named{OptimizeOn::host, "host"},
    Named{OptimizeOn::device, "device"},
};

/// Empty where the value is none of the enumerators.
template <typename Table, typename Enum>
std::string_view name_of(const Table& table, Enum value) noexcept {
    const auto row = std::find_if(table.begin(), table.end(), [&](const auto& named) { return named.value == value; });
    return row == table.end() ? std::string_view{} : row->name;
}

template <typename Enum, std::size_t Size>
std::optional<Enum> value_of(const std::array<Named<Enum>, Size>& table, std::string_view name) noexcept {
    const auto row = std::find_if(table.begin(), table.end(), [&](const auto& named) { return named.name == name; });
    return row == table.end() ? std::nullopt : std::optional<Enum>(row->value);
}

template <typename Enum>
void check_enumerator(std::string_view option, Enum value) {
    if (to_string(value).empty()) {
        reject_field(option, std::to_string(static_cast<unsigned>(value)), "one of its enumerators");
    }
}

void check_code_bits(std::uint32_t bits) {
    const bool valid = bits == 0 || bits == 33 || bits == 44 || bits == 63;
    if (!valid) reject_field("code_bits", std::to_string(bits), "33, 44 or 63, or 0 to have it chosen");
}

void check_chunk_size(std::uint32_t size) {
    const bool valid = size == 0 || (size >= 64 && size <= 4096 && size % 64 == 0);
    if (!valid) reject_field("chunk_size", std::to_string(size), "64 to 4096 in steps of 64, or 0 to have it chosen");
}

void check_work_group_size(std::uint32_t size) {
    const bool valid = size == 0 || (size >= 32 && size <= 1024 && std::has_single_bit(size));
    if (!valid)
        reject_field("work_group_size", std::to_string(size), "a power of two from 32 to 1024, or 0 to have it chosen");
}

void check_single_group_threshold(std::uint32_t count) {
    const bool valid = count == 0 || (count >= 2 && count <= 1u << 20);
    if (!valid) reject_field("single_group_threshold", std::to_string(count), "2 to 1048576, or 0 to have it chosen");
}

void check_range_count(std::uint32_t count) {
    if (count > 512) reject_field("range_count", std::to_string(count), "1 to 512, or 0 to have it chosen");
}

void check_hploc(const BuildOptions& options) {
    check_enumerator("hploc_quality", options.hploc_quality);
    check_enumerator("hploc_search", options.hploc_search);
    const std::uint32_t limit = options.cluster_limit;
    if (limit != 0 && limit != 8 && limit != 16)
        reject_field("cluster_limit", std::to_string(limit), "8 or 16, or 0 to have it chosen");
    check_range("small_range", options.small_range, 0, 1u << 30);
    check_range("small_limit", options.small_limit, 0, 8);
    check_enumerator("merge_pairs", options.merge_pairs);
}

}  // namespace

void check_options(const BuildOptions& options) {
    check_positive("inner_cost", options.inner_cost);
    check_positive("primitive_cost", options.primitive_cost);
    check_range("max_leaf_size", options.max_leaf_size, 0, kMaxLeafSize);
    check_range("bin_count", options.bin_count, 2, kMaxBinCount);
    check_range("split_alpha", options.split_alpha, 0.0f, 1.0f);
    check_range("reference_budget", options.reference_budget, 1.0f, 8.0f);
    check_range("presplit_level", options.presplit_level, 0, kMaxPresplitLevel);
    check_range("split_quota", options.split_quota, 0.0f, kMaxSplitQuota);
    if (options.presplit_level > 0 && options.split_quota > 0.0f) {
        throw Error(ErrorCode::invalid_input,
                    "presplit_level and split_quota are two ways to split triangles: give one");
    }
    check_enumerator("optimize_on", options.optimize_on);
    check_range("thread_count", options.thread_count, 0, 1024);
    check_range("search_radius", options.search_radius, 1, 32);
    check_enumerator("shape", options.shape);
    check_enumerator("sort_shape", options.sort_shape);
    check_enumerator("morton_code", options.morton_code);
    check_code_bits(options.code_bits);
    check_enumerator("neighbour_encoding", options.neighbour_encoding);
    check_enumerator("neighbour_search", options.neighbour_search);
    check_single_group_threshold(options.single_group_threshold);
    check_chunk_size(options.chunk_size);
    check_work_group_size(options.work_group_size);
    check_range_count(options.range_count);
    check_hploc(options);
}

std::string_view to_string(Shape shape) noexcept {
    return name_of(kShapes, shape);
}
std::string_view to_string(MortonCode code) noexcept {
    return name_of(kMortonCodes, code);
}
std::string_view to_string(NeighbourEncoding encoding) noexcept {
    return name_of(kEncodings, encoding);
}
std::string_view to_string(NeighbourSearch search) noexcept {
    return name_of(kSearches, search);
}
std::string_view to_string(HplocQuality quality) noexcept {
    return name_of(kHplocQualities, quality);
}
std::string_view to_string(HplocSearch search) noexcept {
    return name_of(kHplocSearches, search);
}
std::string_view to_string(PairMerging merging) noexcept {
    return name_of(kPairMergings, merging);
}
std::string_view to_string(OptimizeOn where) noexcept {
    return name_of(kOptimizeOn, where);
}

std::optional<Shape> shape_from(std::string_view name) noexcept {
    return value_of(kShapes, name);
}
std::optional<MortonCode> morton_code_from(std::string_view name) noexcept {
    return value_of(kMortonCodes, name);
}
std::optional<NeighbourEncoding> neighbour_encoding_from(std::string_view name) noexcept {
    return value_of(kEncodings, name);
}
std::optional<NeighbourSearch> neighbour_search_from(std::string_view name) noexcept {
    return value_of(kSearches, name);
}
std::optional<HplocQuality> hploc_quality_from(std::string_view name) noexcept {
    return value_of(kHplocQualities, name);
}
std::optional<HplocSearch> hploc_search_from(std::string_view name) noexcept {
    return value_of(kHplocSearches, name);
}
std::optional<PairMerging> pair_merging_from(std::string_view name) noexcept {
    return value_of(kPairMergings, name);
}
std::optional<OptimizeOn> optimize_on_from(std::string_view name) noexcept {
    return value_of(kOptimizeOn, name);
}

}  // namespace clbvh
