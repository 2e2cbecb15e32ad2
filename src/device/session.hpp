#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "clbvh/device/device.hpp"
#include "device/opencl.hpp"

namespace clbvh::device {

/// A kernel that is ready to be launched.
struct Kernel {
    cl::Kernel kernel;
    std::string name;
    std::size_t work_group_size = 1;
};

/// A device, its context and queue, and what was built for it. What Context shares among its copies.
class Session {
public:
    explicit Session(const DeviceInfo& info);
    explicit Session(cl_command_queue queue);

    [[nodiscard]] const DeviceInfo& info() const noexcept { return info_; }
    [[nodiscard]] const cl::Context& context() const noexcept { return context_; }
    [[nodiscard]] const cl::CommandQueue& queue() const noexcept { return queue_; }
    [[nodiscard]] bool profiles() const noexcept { return profiles_; }

    /// Kernel `name` of kernels/`file`, built with `options` and WORK_GROUP_SIZE on first use.
    /// Throws Error(device_failure) with the build log where the program does not build.
    Kernel& kernel(std::string_view file, std::string_view name, std::size_t work_group_size,
                   const std::string& options);

    /// True for a CPU device on which kernels with one work item a group pass a small self-test.
    bool prefers_lane_shape();

private:
    cl::Program build_program(const std::string& file, const std::string& options) const;

    DeviceInfo info_;
    cl::Device device_;
    cl::Context context_;
    cl::CommandQueue queue_;
    bool profiles_ = true;
    std::map<std::string, cl::Program> programs_;
    std::map<std::string, Kernel> kernels_;
    std::optional<bool> lane_shape_works_;
};

}  // namespace clbvh::device
