#pragma once

#include <cstdint>

#include "clbvh/device/shape.hpp"

namespace clbvh {

/// How optimisers run on a device. The shape never changes what comes out.
struct DeviceOptimizerOptions {
    Shape shape = Shape::automatic;    ///< See Shape.
    std::uint32_t passes = 0;          ///< Most passes of each optimiser, up to 1000; 0: its own limit.
    std::uint32_t treelet_leaves = 7;  ///< treelet: leaves of a treelet, 3 to 8.
};

}  // namespace clbvh
