#pragma once

#include <CL/cl.h>

#include <memory>
#include <string_view>

#include "clbvh/device/device.hpp"

namespace clbvh {

namespace device {
class Session;
}

/// A device with its OpenCL context, its queue and the programs built for it. Cheap to copy: copies share everything.
/// Programs are built on first use and kept as long as any copy lives. One thread at a time.
class Context {
public:
    /// Opens the device that pick_device(selector) picks, with a context and an in-order profiling queue of its own.
    [[nodiscard]] static Context open(std::string_view selector = {});

    /// Adopts the caller's in-order queue and retains it, its context and its device. Stage device times are 0 where
    /// the queue was made without CL_QUEUE_PROFILING_ENABLE. Throws Error(unsupported) for an out-of-order queue.
    [[nodiscard]] static Context adopt(cl_command_queue queue);

    [[nodiscard]] const DeviceInfo& device() const noexcept;
    [[nodiscard]] cl_context opencl_context() const noexcept;
    [[nodiscard]] cl_command_queue opencl_queue() const noexcept;

    /// True where the lane shape may be the default here: a CPU device that passes a small self-test (run once).
    [[nodiscard]] bool prefers_lane_shape() const;

    /// What the device builders share; private to the library.
    [[nodiscard]] device::Session& session() const noexcept { return *session_; }

private:
    explicit Context(std::shared_ptr<device::Session> session);
    std::shared_ptr<device::Session> session_;
};

}  // namespace clbvh
