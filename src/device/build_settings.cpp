#include "device/build_settings.hpp"

#include <algorithm>
#include <bit>

#include "clbvh/core/error.hpp"
#include "device/build_buffers.hpp"

namespace clbvh::device {
namespace {

constexpr std::size_t kGpuGroup = 1024;
// A CPU runs the items of a group one after the other: a large group only makes the last few clusters of a range dear.
constexpr std::size_t kCpuGroup = 256;
constexpr std::size_t kStreamGroup = 256;
constexpr std::uint32_t kLaneChunk = 512;
// Groups a compute unit: on a CPU enough to even out their lengths, on a GPU enough to hide each other's latency.
constexpr std::uint32_t kCpuGroupsPerUnit = 8;
constexpr std::uint32_t kGpuGroupsPerUnit = 4;
// A lane keeps a counter and an open cache line for each digit, so few long pieces beat many short ones.
constexpr std::uint32_t kLaneSortPiecesPerUnit = 4;
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

std::size_t stream_group_size(const DeviceInfo& info) {
    return std::min(kStreamGroup, std::bit_floor(info.max_work_group_size));
}

void resolve_sort(BuildSettings& settings, const DeviceInfo& info) {
    const bool lane = settings.sort_shape == Shape::lane;
    settings.sort_group_size = lane ? 1 : stream_group_size(info);
    settings.most_sort_pieces = lane ? std::min(info.compute_units * kLaneSortPiecesPerUnit, BuildBuffers::kMostPieces)
                                     : settings.groups_to_fill;
}

void resolve_group_sizes(BuildSettings& settings, const BuildOptions& options, const DeviceInfo& info) {
    const std::size_t largest = group_size_that_fits(info, settings.exact_distances);
    const std::size_t chosen = info.type == DeviceType::cpu ? std::min(kCpuGroup, largest) : largest;
    settings.cluster_group_size = options.work_group_size != 0 ? options.work_group_size : chosen;
    settings.stream_group_size = stream_group_size(info);
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
}

Shape definite_shape(Shape shape, Session& session) {
    if (shape != Shape::automatic) {
        return shape;
    }
    return session.prefers_lane_shape() ? Shape::lane : Shape::group;
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
    settings.shape = definite_shape(options.shape, session);
    settings.sort_shape = definite_shape(options.sort_shape, session);
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
    const std::uint32_t per_unit = info.type == DeviceType::cpu ? kCpuGroupsPerUnit : kGpuGroupsPerUnit;
    settings.groups_to_fill = std::min(info.compute_units * per_unit, BuildBuffers::kMostPieces);
    resolve_sort(settings, info);
    if (settings.lane()) {
        resolve_lane_sizes(settings, options, info);
    } else {
        resolve_group_sizes(settings, options, info);
    }
    // Twice the groups that fill the device (section 5.1), and no fewer than keep a range in a CPU's second-level
    // cache. The same for both shapes, so that both give the same tree.
    const std::uint32_t chosen_ranges = std::max(kLeastRanges, 2 * settings.groups_to_fill);
    settings.range_count = options.range_count != 0 ? options.range_count : std::min(kMostRanges, chosen_ranges);
    return settings;
}

}  // namespace clbvh::device
