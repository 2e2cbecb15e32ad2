#pragma once

#include <cstdint>
#include <string>

#include "clbvh/device/device_builder_configs.hpp"
#include "device/opencl/device_fit.hpp"
#include "kernels/build/build_constants.h"

namespace clbvh::device {

/// A packed key: leading bits of the code above the bits of the primitive's index.
struct KeyLayout {
    std::uint32_t index_bits;
    std::uint32_t code_bits;
};

struct DeviceAlgorithm;

/// A builder's options made definite for one device: every automatic choice taken, every size known.
struct BuildSettings : DeviceFit {
    DeviceBuilderConfigs configs;  ///< As they were given; what they leave to be chosen is chosen below.
    bool exact_distances = false;  ///< 64-bit neighbour encoding
    bool symmetric_search = true;
    std::uint32_t single_group_threshold = 0;
    std::uint32_t range_count = 0;                 ///< least number of Morton ranges of plocpp-two-level
    std::size_t cluster_group_size = 1;            ///< work items a group in kernels that search neighbours
    std::uint32_t lane_chunk_size = 0;             ///< clusters a chunk in the lane shape
    Shape sort_shape = Shape::group;               ///< group or lane
    std::size_t sort_group_size = 1;               ///< work items a group in the sort
    std::uint32_t most_sort_pieces = 1;            ///< work groups of a pass of the sort
    HandOver hand_over = HandOver::within_launch;  ///< never automatic
    /// Most iterations that are enqueued before their counts are read, 1 to 64. The same on every device: tests look at
    /// one iteration at a time by setting it.
    std::uint32_t iterations_in_flight = 8;

    /// True where what groups hand over waits for the end of a launch.
    [[nodiscard]] bool climbs_in_steps() const noexcept { return !lane() && hand_over == HandOver::between_launches; }
    /// Pieces of a pass of the sort.
    [[nodiscard]] Pieces sort_pieces(std::uint32_t elements) const;
    /// Bits that a pass of the sort looks at.
    [[nodiscard]] std::uint32_t sort_digit_bits() const noexcept {
        return sort_shape == Shape::lane ? kernels::LANE_RADIX_BITS : kernels::GROUP_RADIX_BITS;
    }
    /// True where code and index are sorted as one 64-bit key, false for pairs of 32-bit keys with a value.
    [[nodiscard]] bool packed_keys() const noexcept { return configs.device.code_bits < 63; }
    /// True where runs of equal codes are coded again.
    [[nodiscard]] bool recodes() const noexcept {
        return packed_keys() && configs.device.morton_code == MortonCode::cubic;
    }
    [[nodiscard]] KeyLayout key_layout(std::uint32_t primitives) const;
    /// True where leaves may have several primitives.
    [[nodiscard]] bool groups_primitives() const noexcept { return configs.hploc.leaf_size > 1; }
    /// Clusters a chunk where `border` more are loaded to each side.
    [[nodiscard]] std::uint32_t chunk_size(std::uint32_t border) const noexcept {
        return lane() ? lane_chunk_size : static_cast<std::uint32_t>(cluster_group_size) - 2 * border;
    }
    /// -D options for kernels that search neighbours.
    [[nodiscard]] std::string search_defines() const;
};

/// Takes every automatic choice of `algorithm` for `session`'s device. `configs` are in range. Throws
/// Error(invalid_input) where they contradict each other, and Error(unsupported) where the device cannot do what they
/// ask.
[[nodiscard]] BuildSettings resolve_settings(const DeviceAlgorithm& algorithm, const DeviceBuilderConfigs& configs,
                                             Session& session);

}  // namespace clbvh::device
