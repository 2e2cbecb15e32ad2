#include "device/opencl/device_fit.hpp"

#include <algorithm>
#include <bit>

namespace clbvh::device {
namespace {

constexpr std::size_t kStreamGroup = 256;
// Groups a compute unit: on a CPU enough to even out their lengths, on a GPU enough to hide each other's latency.
constexpr std::uint32_t kCpuGroupsPerUnit = 8;
constexpr std::uint32_t kGpuGroupsPerUnit = 4;
// Passes over arrays are short: in the group shape more groups even them out.
constexpr std::uint32_t kStreamGroupsPerGroup = 4;

}  // namespace

Pieces cut_into_pieces(std::uint32_t elements, std::uint32_t most, std::uint32_t granularity) {
    const std::uint64_t grains = (std::uint64_t{elements} + granularity - 1) / granularity;
    const std::uint64_t grains_per_piece = std::max<std::uint64_t>(1, (grains + most - 1) / most);
    const std::uint64_t count = std::max<std::uint64_t>(1, (grains + grains_per_piece - 1) / grains_per_piece);
    return {static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(grains_per_piece * granularity)};
}

Pieces DeviceFit::stream_pieces(std::uint32_t elements) const {
    return cut_into_pieces(elements, std::min(groups_to_fill * (lane() ? 1 : kStreamGroupsPerGroup), kMostPieces),
                           static_cast<std::uint32_t>(stream_group_size));
}

Shape definite_shape(Session& session, Shape shape) {
    if (shape != Shape::automatic) return shape;
    return session.prefers_lane_shape() ? Shape::lane : Shape::group;
}

std::size_t stream_group_size(const DeviceInfo& info) {
    return std::min(kStreamGroup, std::bit_floor(info.max_work_group_size));
}

DeviceFit fit_to_device(Session& session, Shape shape) {
    const DeviceInfo& info = session.info();
    DeviceFit fit;
    fit.shape = definite_shape(session, shape);
    fit.stream_group_size = fit.lane() ? 1 : stream_group_size(info);
    const std::uint32_t per_unit = info.type == DeviceType::cpu ? kCpuGroupsPerUnit : kGpuGroupsPerUnit;
    fit.groups_to_fill = std::min(info.compute_units * per_unit, kMostPieces);
    return fit;
}

}  // namespace clbvh::device
