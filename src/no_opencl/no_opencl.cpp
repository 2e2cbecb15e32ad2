// Stands in for the device's rooms in a build without OpenCL (CLBVH_WITH_OPENCL=OFF): there is no device, and whoever
// asks for one is told why.
#include <cstdlib>

#include "build/backend.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/device/device.hpp"
#include "clbvh/device/profile.hpp"

namespace clbvh {
namespace {

[[noreturn]] void refuse() {
    throw Error(ErrorCode::unsupported,
                "this build of libclbvh has no OpenCL; take a builder that runs on the host, or configure the library "
                "with CLBVH_WITH_OPENCL=ON");
}

}  // namespace

std::vector<DeviceInfo> list_devices(std::vector<PlatformFault>*) {
    return {};
}

DeviceInfo pick_device(std::string_view) {
    refuse();
}

FoundProfile find_profile(const DeviceInfo&) {
    return {};
}

Context Context::open(std::string_view, const ContextOptions&) {
    refuse();
}

Context Context::adopt(cl_command_queue, const ContextOptions&) {
    refuse();
}

// No context is ever made, so nobody can call these.
const DeviceInfo& Context::device() const noexcept {
    std::abort();
}
cl_context Context::opencl_context() const noexcept {
    std::abort();
}
cl_command_queue Context::opencl_queue() const noexcept {
    std::abort();
}
const FoundProfile& Context::profile() const noexcept {
    std::abort();
}
bool Context::prefers_lane_shape() const {
    std::abort();
}
bool Context::passes_hand_over_check() const {
    std::abort();
}

std::unique_ptr<Backend> make_device_backend(const BuilderRow&, const BuildOptions&, const Context&, tbb::task_arena&) {
    refuse();
}

}  // namespace clbvh
