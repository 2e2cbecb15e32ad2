#pragma once

#include "clbvh/device/device.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh::device {

/// Everything of DeviceInfo but the index, which is the listing's.
[[nodiscard]] DeviceInfo describe_device(const cl::Device& device);

}  // namespace clbvh::device
