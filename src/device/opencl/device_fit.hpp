#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "device/opencl/session.hpp"

namespace clbvh::device {

/// Most pieces that any pass over arrays is cut into.
inline constexpr std::uint32_t kMostPieces = 1024;

/// Work cut into equal contiguous pieces, one work group each.
struct Pieces {
    std::uint32_t count;   ///< at least 1
    std::uint32_t length;  ///< elements a piece, a multiple of the granularity
};

/// Cuts `elements` into at most `most` pieces whose length is a multiple of `granularity`.
[[nodiscard]] Pieces cut_into_pieces(std::uint32_t elements, std::uint32_t most, std::uint32_t granularity);

/// How work is laid out for one device, whatever the algorithm.
struct DeviceFit {
    Shape shape = Shape::group;         ///< group or lane
    std::size_t stream_group_size = 1;  ///< work items a group in kernels that pass over arrays; 1 in the lane shape
    std::uint32_t groups_to_fill = 1;   ///< work groups that keep the whole device busy

    [[nodiscard]] bool lane() const noexcept { return shape == Shape::lane; }
    /// Pieces of a pass over an array of `elements`.
    [[nodiscard]] Pieces stream_pieces(std::uint32_t elements) const;
};

/// How many of `groups` may take part in a launch in which they hand over to each other: one, which hands over to
/// itself alone, where that has to wait for the launch's end.
[[nodiscard]] constexpr std::size_t meeting_groups(HandOver hand_over, std::size_t groups) noexcept {
    return hand_over == HandOver::within_launch ? groups : std::min<std::size_t>(groups, 1);
}

/// `shape`, or what an automatic one is on this device: lane on CPUs that pass the self-test, else group.
[[nodiscard]] Shape definite_shape(Session& session, Shape shape);

/// Work items a group in the group shape's kernels that pass over arrays.
[[nodiscard]] std::size_t stream_group_size(const DeviceInfo& info);

/// How work of this shape, which may be automatic, is laid out for the session's device.
[[nodiscard]] DeviceFit fit_to_device(Session& session, Shape shape);

}  // namespace clbvh::device
