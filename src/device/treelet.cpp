// Karras, Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", section 3.

#include "device/device_optimizer_row.hpp"

namespace clbvh::device {
namespace {

std::vector<ProgramSpec> programs(const OptimizeSettings&) {
    return {};
}

std::uint64_t scratch_bytes(const OptimizeSettings&, std::uint32_t) {
    return 0;
}

void launch(const OptimizeJob&) {}

}  // namespace

const DeviceOptimizerRow kTreelet{programs, scratch_bytes, launch};

}  // namespace clbvh::device
