#include "device/build_settings.hpp"

#include <algorithm>
#include <bit>

#include "clbvh/core/error.hpp"
#include "device/build_buffers.hpp"

namespace clbvh::device {
namespace {

constexpr std::size_t kLargestGroup = 1024;
constexpr std::size_t kStreamGroup = 256;
constexpr std::uint32_t kLaneChunk = 256;
constexpr std::uint32_t kLanePiecesPerUnit = 8;
constexpr std::uint32_t kLaneRanges = 64;
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
    std::size_t size = std::min(kLargestGroup, std::bit_floor(info.max_work_group_size));
    while (size > 32 && group_local_bytes(size, exact) > info.local_memory_bytes) {
        size /= 2;
    }
    return size;
}

void resolve_group_sizes(BuildSettings& settings, const BuildOptions& options, const DeviceInfo& info) {
    const std::size_t largest = group_size_that_fits(info, settings.exact_distances);
    settings.cluster_group_size = options.work_group_size != 0 ? options.work_group_size : largest;
    settings.stream_group_size = std::min(kStreamGroup, std::bit_floor(info.max_work_group_size));
    if (settings.cluster_group_size > largest) {
        throw Error(ErrorCode::unsupported, "work_group_size " + std::to_string(settings.cluster_group_size) +
                                                " is too large for " + info.name + ", which fits " +
                                                std::to_string(largest));
    }
    if (settings.cluster_group_size <= 4 * settings.search_radius) {
        throw Error(ErrorCode::invalid_input,
                    "work_group_size " + std::to_string(settings.cluster_group_size) +
                        " leaves no chunk beside 4 * search_radius = " + std::to_string(4 * settings.search_radius));
    }
    // Groups that fit a compute unit together hide each other's latency; a CPU runs them one after the other.
    settings.groups_to_fill = info.compute_units * (info.type == DeviceType::cpu ? kLanePiecesPerUnit : 4);
}

void resolve_lane_sizes(BuildSettings& settings, const BuildOptions& options, const DeviceInfo& info) {
    settings.lane_chunk_size = options.chunk_size != 0 ? options.chunk_size : kLaneChunk;
    while (options.chunk_size == 0 && settings.lane_chunk_size > 64 &&
           lane_local_bytes(settings.lane_chunk_size, settings.search_radius) > info.local_memory_bytes) {
        settings.lane_chunk_size /= 2;
    }
    if (lane_local_bytes(settings.lane_chunk_size, settings.search_radius) > info.local_memory_bytes) {
        throw Error(ErrorCode::unsupported, "chunk_size " + std::to_string(settings.lane_chunk_size) +
                                                " needs more local memory than the " +
                                                std::to_string(info.local_memory_bytes) + " bytes of " + info.name);
    }
    settings.groups_to_fill = info.compute_units * kLanePiecesPerUnit;
}

}  // namespace

std::string BuildSettings::search_defines() const {
    return " -D SEARCH_RADIUS=" + std::to_string(search_radius) + " -D ENCODING=" + (exact_distances ? "64" : "32") +
           " -D SYMMETRIC_SEARCH=" + (symmetric_search ? "1" : "0") +
           (lane() ? " -D CHUNK=" + std::to_string(lane_chunk_size) : "");
}

Pieces BuildSettings::stream_pieces(std::uint32_t elements) const {
    return cut_into_pieces(elements, std::min(groups_to_fill * (lane() ? 1 : 4), BuildBuffers::kMostPieces),
                           static_cast<std::uint32_t>(stream_group_size));
}

Pieces cut_into_pieces(std::uint32_t elements, std::uint32_t most, std::uint32_t granularity) {
    const std::uint64_t grains = (std::uint64_t{elements} + granularity - 1) / granularity;
    const std::uint64_t grains_per_piece = std::max<std::uint64_t>(1, (grains + most - 1) / most);
    const std::uint64_t count = std::max<std::uint64_t>(1, (grains + grains_per_piece - 1) / grains_per_piece);
    return {static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(grains_per_piece * granularity)};
}

BuildSettings resolve_settings(const BuildOptions& options, Session& session) {
    check_options(options);
    const DeviceInfo& info = session.info();
    BuildSettings settings;
    settings.shape = options.shape;
    if (options.shape == Shape::automatic) {
        settings.shape = session.prefers_lane_shape() ? Shape::lane : Shape::group;
    }
    settings.search_radius = options.search_radius;
    settings.morton_code = options.morton_code;
    settings.exact_distances = options.neighbour_encoding == NeighbourEncoding::bits64;
    settings.symmetric_search =
        options.neighbour_search == NeighbourSearch::symmetric ||
        (options.neighbour_search == NeighbourSearch::automatic && info.type != DeviceType::cpu);
    if (!settings.lane() && settings.exact_distances && settings.symmetric_search && !info.int64_atomics) {
        if (options.neighbour_search == NeighbourSearch::symmetric) {
            throw Error(ErrorCode::unsupported,
                        "neighbour_encoding bits64 with neighbour_search symmetric needs 64-bit atomics, which " +
                            info.name + " lacks; use neighbour_search scan or neighbour_encoding bits32");
        }
        settings.symmetric_search = false;
    }
    settings.single_group_threshold = options.single_group_threshold;
    if (settings.lane()) {
        resolve_lane_sizes(settings, options, info);
    } else {
        resolve_group_sizes(settings, options, info);
    }
    const std::uint32_t chosen_ranges = std::max(kLaneRanges, 2 * settings.groups_to_fill);
    settings.range_count = options.range_count != 0 ? options.range_count : std::min(kMostRanges, chosen_ranges);
    return settings;
}

}  // namespace clbvh::device
