#pragma once

#include "device/build_buffers.hpp"
#include "device/launcher.hpp"

namespace clbvh::device {

/// What a clustering finds, and what it leaves: buffers.leaves holds `leaf_count` (at least 1) boxes in Morton order
/// and buffers.codes their codes; afterwards buffers.nodes holds every sibling pair, and buffers.root_reference the
/// root.
struct ClusterJob {
    Launcher& launcher;
    const BuildSettings& settings;
    const BuildBuffers& buffers;
    std::uint32_t leaf_count;
};

/// What makes one device builder different from the next.
struct DeviceAlgorithm {
    void (*cluster)(const ClusterJob& job);
    /// Device memory beside what every build uses.
    std::uint64_t (*extra_bytes)(const BuildSettings& settings, std::uint32_t primitives);
};

extern const DeviceAlgorithm kPloc;
extern const DeviceAlgorithm kPlocpp;
extern const DeviceAlgorithm kPlocppTwoLevel;
extern const DeviceAlgorithm kLbvh;

/// The part of a build that is done when `clusters` of `leaf_count` are left.
[[nodiscard]] constexpr double cluster_fraction(std::uint32_t clusters, std::uint32_t leaf_count) {
    return 0.3 + 0.65 * (1.0 - static_cast<double>(clusters) / leaf_count);
}

}  // namespace clbvh::device
