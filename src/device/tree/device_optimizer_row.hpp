#pragma once

#include <cstdint>
#include <vector>

#include "device/opencl/device_fit.hpp"
#include "device/opencl/launcher.hpp"
#include "device/opencl/memory_block.hpp"
#include "device/tree/parents.hpp"

namespace clbvh::device {

/// DeviceOptimizerOptions with everything chosen for one device.
struct OptimizeSettings : DeviceFit {
    std::uint32_t passes = 0;                      ///< most of each optimiser; 0: its own limit
    std::uint32_t treelet_leaves = 7;              ///< of `treelet`
    HandOver hand_over = HandOver::within_launch;  ///< never automatic
};

/// A tree to be improved in place.
struct OptimizeJob {
    Launcher& launcher;  ///< Its stage has begun.
    const OptimizeSettings& settings;
    TreeNodes tree;  ///< At least 6 nodes, an even number. Where there are no leaves node 0 is no node.
    Block scratch;   ///< As the row asked, aligned for views.
};

/// The part in which device optimisers differ. None waits for the device.
struct DeviceOptimizerRow {
    std::vector<ProgramSpec> (*programs)(const OptimizeSettings& settings);
    /// Local memory of a work group in the lane shape; that of the group shape fits any device.
    std::uint64_t (*lane_local_bytes)(const OptimizeSettings& settings);
    std::uint64_t (*scratch_bytes)(const OptimizeSettings& settings, std::uint32_t node_count);
    void (*launch)(const OptimizeJob& job);
};

extern const DeviceOptimizerRow kReinsert;
extern const DeviceOptimizerRow kTreelet;

}  // namespace clbvh::device
