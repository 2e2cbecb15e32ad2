#include "device/build/build_settings.hpp"

#include <algorithm>
#include <bit>
#include <initializer_list>

#include "clbvh/core/error.hpp"
#include "device/build/device_algorithm.hpp"

namespace clbvh::device {
namespace {

constexpr std::size_t kGpuGroup = 1024;
// A CPU runs the items of a group one after the other: a large group only makes the last few clusters of a range dear.
constexpr std::size_t kCpuGroup = 256;
constexpr std::uint32_t kLaneChunk = 512;
// A lane keeps a counter and an open cache line for each digit, so few long pieces beat many short ones.
constexpr std::uint32_t kLaneSortPiecesPerUnit = 4;
constexpr std::uint32_t kLeastLaneSortPiece = 8192;
constexpr std::uint32_t kSortTile = 256 * kernels::TILE_ELEMENTS_PER_ITEM;  // of the largest group
constexpr std::uint32_t kSingleGroupThreshold = 8192;
constexpr std::uint32_t kLeastRanges = 256;
constexpr std::uint32_t kMostRanges = 512;

// Local bytes of the kernels that search neighbours; see plocpp.cl.
std::size_t group_local_bytes(std::size_t group_size, bool exact) {
    return (10 + (exact ? 2 : 1)) * group_size * 4 + 8192;
}

std::size_t lane_local_bytes(std::size_t chunk, std::size_t radius) {
    const std::size_t stride = chunk + 4 * radius + radius + 48;
    return (9 + radius) * stride * 4 + 8 * chunk + 8192;
}

std::size_t group_size_that_fits(const DeviceInfo& info, bool exact) {
    std::size_t size = std::min(kGpuGroup, std::bit_floor(info.max_work_group_size));
    while (size > 32 && group_local_bytes(size, exact) > info.local_memory_bytes) {
        size /= 2;
    }
    return size;
}

void resolve_sort(BuildSettings& settings, const DeviceInfo& info) {
    const bool lane = settings.sort_shape == Shape::lane;
    settings.sort_group_size = lane ? 1 : stream_group_size(info);
    settings.most_sort_pieces =
        lane ? std::min(info.compute_units * kLaneSortPiecesPerUnit, kMostPieces) : settings.groups_to_fill;
}

std::size_t chosen_group_size(const BuildSettings& settings, const Profile& profile, const DeviceInfo& info,
                              std::size_t largest) {
    if (profile.work_group_size > 4 * settings.configs.ploc.search_radius && profile.work_group_size <= largest) {
        return profile.work_group_size;
    }
    return info.type == DeviceType::cpu ? std::min(kCpuGroup, largest) : largest;
}

void resolve_group_sizes(BuildSettings& settings, const PlocConfig& config, const Profile& profile,
                         const DeviceInfo& info) {
    const std::size_t largest = group_size_that_fits(info, settings.exact_distances);
    settings.cluster_group_size =
        config.work_group_size != 0 ? config.work_group_size : chosen_group_size(settings, profile, info, largest);
    if (settings.cluster_group_size > largest) {
        throw Error(ErrorCode::unsupported, "work_group_size " + std::to_string(settings.cluster_group_size) +
                                                " is too large for " + info.name + ", which fits " +
                                                std::to_string(largest));
    }
    if (settings.cluster_group_size <= std::size_t{4} * settings.configs.ploc.search_radius) {
        throw Error(ErrorCode::invalid_input, "work_group_size " + std::to_string(settings.cluster_group_size) +
                                                  " leaves no chunk beside 4 * search_radius = " +
                                                  std::to_string(4 * settings.configs.ploc.search_radius));
    }
}

std::uint32_t chosen_lane_chunk(const BuildSettings& settings, const Profile& profile, const DeviceInfo& info) {
    const auto fits = [&](std::uint32_t chunk) {
        return lane_local_bytes(chunk, settings.configs.ploc.search_radius) <= info.local_memory_bytes;
    };
    if (profile.chunk_size != 0 && fits(profile.chunk_size)) return profile.chunk_size;
    std::uint32_t chunk = kLaneChunk;
    while (chunk > 64 && !fits(chunk))
        chunk /= 2;
    return chunk;
}

void resolve_lane_sizes(BuildSettings& settings, const PlocConfig& config, const Profile& profile,
                        const DeviceInfo& info) {
    settings.lane_chunk_size = config.chunk_size != 0 ? config.chunk_size : chosen_lane_chunk(settings, profile, info);
    if (lane_local_bytes(settings.lane_chunk_size, settings.configs.ploc.search_radius) > info.local_memory_bytes) {
        throw Error(ErrorCode::unsupported, "chunk_size " + std::to_string(settings.lane_chunk_size) +
                                                " needs more local memory than the " +
                                                std::to_string(info.local_memory_bytes) + " bytes of " + info.name);
    }
}

std::uint32_t first_not_zero(std::initializer_list<std::uint32_t> values) {
    return *std::ranges::find_if(values, [](std::uint32_t value) { return value != 0; });
}

}  // namespace

std::string BuildSettings::search_defines() const {
    return " -D SEARCH_RADIUS=" + std::to_string(configs.ploc.search_radius) +
           " -D ENCODING=" + (exact_distances ? "64" : "32") +
           " -D SYMMETRIC_SEARCH=" + (symmetric_search ? "1" : "0") +
           (lane() ? " -D CHUNK=" + std::to_string(lane_chunk_size) : "");
}

Pieces BuildSettings::sort_pieces(std::uint32_t elements) const {
    return cut_into_pieces(elements, most_sort_pieces,
                           sort_shape == Shape::lane ? std::clamp(elements, 1u, kLeastLaneSortPiece) : kSortTile);
}

KeyLayout BuildSettings::key_layout(std::uint32_t primitives) const {
    const auto index_bits = static_cast<std::uint32_t>(std::bit_width(primitives - 1));
    return {index_bits, std::min(configs.device.code_bits, 64 - index_bits)};
}

BuildSettings resolve_settings(const DeviceAlgorithm& algorithm, const DeviceBuilderConfigs& configs,
                               Session& session) {
    const DeviceConfig& device = configs.device;
    const PlocConfig& ploc = configs.ploc;
    const DeviceInfo& info = session.info();
    const Profile profile = session.profile().profile.value_or(Profile{});
    BuildSettings settings;
    settings.configs = configs;
    static_cast<DeviceFit&>(settings) = fit_to_device(session, device.shape);
    // The lane shape needs its self-test, whatever a profile says.
    const bool sorts_in_groups = device.sort_shape == Shape::automatic && profile.sort_shape == Shape::group;
    settings.sort_shape = sorts_in_groups ? Shape::group : definite_shape(session, device.sort_shape);
    settings.exact_distances = ploc.neighbour_encoding == NeighbourEncoding::bits64;
    settings.symmetric_search = ploc.neighbour_search == NeighbourSearch::symmetric ||
                                (ploc.neighbour_search == NeighbourSearch::automatic && info.type != DeviceType::cpu);
    if (!settings.lane() && settings.exact_distances && settings.symmetric_search && !info.int64_atomics) {
        if (ploc.neighbour_search == NeighbourSearch::symmetric) {
            throw Error(ErrorCode::unsupported,
                        "neighbour_encoding bits64 with neighbour_search symmetric needs 64-bit atomics, which " +
                            info.name + " lacks; use neighbour_search scan or neighbour_encoding bits32");
        }
        settings.symmetric_search = false;
    }
    if (algorithm.hands_over && !settings.lane()) settings.hand_over = session.hand_over();
    settings.single_group_threshold =
        first_not_zero({ploc.single_group_threshold, profile.single_group_threshold, kSingleGroupThreshold});
    resolve_sort(settings, info);
    if (!algorithm.searches_chunks) {
        settings.cluster_group_size = settings.stream_group_size;
    } else if (settings.lane()) {
        resolve_lane_sizes(settings, ploc, profile, info);
    } else {
        resolve_group_sizes(settings, ploc, profile, info);
    }
    // Twice the groups that fill the device (section 5.1), at most kMostRanges, and no fewer than keep a range in a
    // CPU's second-level cache. The same for both shapes, so that both give the same tree.
    const std::uint32_t chosen_ranges = std::max(kLeastRanges, 2 * settings.groups_to_fill);
    settings.range_count = ploc.range_count != 0 ? ploc.range_count : std::min(kMostRanges, chosen_ranges);
    return settings;
}

}  // namespace clbvh::device
