#include "clbvh/core/build_options.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include "core/check_field.hpp"

namespace clbvh {
namespace {

template <typename Enum>
struct Named {
    Enum value;
    std::string_view name;
};

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

void check_chunk_size(std::uint32_t size) {
    const bool valid = size == 0 || (size >= 64 && size <= 4096 && size % 64 == 0);
    if (!valid) reject_field("chunk_size", std::to_string(size), "64 to 4096 in steps of 64, or 0 to have it chosen");
}

void check_work_group_size(std::uint32_t size) {
    const bool valid = size == 0 || (size >= 32 && size <= 1024 && std::has_single_bit(size));
    if (!valid)
        reject_field("work_group_size", std::to_string(size), "a power of two from 32 to 1024, or 0 to have it chosen");
}

void check_range_count(std::uint32_t count) {
    if (count > 512) reject_field("range_count", std::to_string(count), "1 to 512, or 0 to have it chosen");
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
    check_range("thread_count", options.thread_count, 0, 1024);
    check_range("search_radius", options.search_radius, 1, 32);
    check_enumerator("shape", options.shape);
    check_enumerator("sort_shape", options.sort_shape);
    check_enumerator("morton_code", options.morton_code);
    check_enumerator("neighbour_encoding", options.neighbour_encoding);
    check_enumerator("neighbour_search", options.neighbour_search);
    check_range("single_group_threshold", options.single_group_threshold, 2, 1u << 20);
    check_chunk_size(options.chunk_size);
    check_work_group_size(options.work_group_size);
    check_range_count(options.range_count);
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

}  // namespace clbvh
