#pragma once

#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"
#include "host/top_down/cluster_top.hpp"

namespace clbvh::device {

/// Input and output of a clustering: buffers.primitive_count says how many primitives there are, buffers.primitive_ids
/// and buffers.codes name them in Morton order, and their boxes are in buffers.leaves (in that order) or buffers.boxes
/// (by primitive), as DeviceAlgorithm::box_order asks. Afterwards buffers.nodes holds every sibling pair,
/// buffers.root_reference the root, and buffers.leaf_count the number of leaves.
struct ClusterJob {
    Launcher& launcher;
    const BuildSettings& settings;
    const BuildBuffers& buffers;
    std::uint32_t leaf_count;  ///< what buffers.primitive_count holds, at least 1; launches are sized by it
    /// The host must not wait for the device where that can be helped, and leaf_count is an upper bound: what
    /// buffers.primitive_count holds may be less, and 0.
    bool asynchronous = false;
    host::TopMemory* top_memory = nullptr;  ///< Where DeviceAlgorithm::uses_host is set, else null.
};

/// The part in which one device builder differs from the next.
struct DeviceAlgorithm {
    void (*cluster)(const ClusterJob& job);
    /// Device memory beside what every build uses.
    std::uint64_t (*extra_bytes)(const BuildSettings& settings, std::uint32_t primitives);
    BoxOrder box_order = BoxOrder::morton;
    /// The program of its kernels, beside those of the stages.
    ProgramSpec (*program)(const BuildSettings& settings);
    /// Its kernels search chunks of clusters: PlocConfig's chunk_size and work_group_size are heeded, and have to fit
    /// the search radius and local memory.
    bool searches_chunks = false;
    /// The host builds the top of the tree, and waits for the device before: not where ClusterJob::asynchronous is set.
    bool uses_host = false;
    /// In the group shape its kernels climb trees, where work groups hand over to each other.
    bool hands_over = false;
};

/// Bytes that a round of clustering has to move: every cluster's reference and record are read, `array_bytes` more pass
/// through arrays of its own; a merge writes a record and a sibling pair.
[[nodiscard]] constexpr std::uint64_t round_bytes(std::uint64_t clusters, std::uint64_t merges,
                                                  std::uint64_t array_bytes) {
    return (4 + 32 + array_bytes) * clusters + (32 + 64) * merges;
}

/// The part of a build that is done when `clusters` of `leaf_count` are left.
[[nodiscard]] constexpr double cluster_fraction(std::uint32_t clusters, std::uint32_t leaf_count) {
    return 0.3 + 0.65 * (1.0 - static_cast<double>(clusters) / leaf_count);
}

}  // namespace clbvh::device
