#pragma once

#include "clbvh/device/device_config.hpp"
#include "clbvh/device/hploc.hpp"
#include "clbvh/device/ploc.hpp"

namespace clbvh {

/// The options of device builders: those of all, and a Config for each builder or family that has options of its own.
struct DeviceBuilderConfigs {
    DeviceConfig device;  ///< All device builders.
    PlocConfig ploc;
    HplocConfig hploc;
};

}  // namespace clbvh
