#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "clbvh/device/device.hpp"
#include "clbvh/device/hand_over.hpp"
#include "clbvh/device/opencl_handles.hpp"
#include "clbvh/device/profile.hpp"
#include "clbvh/export.h"

namespace clbvh {

namespace device {
class Session;
}

/// Whether compiled programs are kept on disk, so that the next process need not compile them: in CLBVH_CACHE_DIR, else
/// in clbvh below XDG_CACHE_HOME or ~/.cache, at most 64 MiB. A damaged or foreign file there is never used.
enum class ProgramCaching : std::uint8_t {
    automatic,  ///< As the variable CLBVH_CACHE says (auto, on, off); else on where the driver keeps none of its own.
    on,         ///< Always.
    off,        ///< Never: nothing is read or written.
};

/// How a context is made.
struct ContextOptions {
    ProgramCaching program_caching = ProgramCaching::automatic;  ///< See ProgramCaching.
    bool use_profile = true;  ///< Let find_profile(device) stand in for automatic options.
    /// See HandOver. Where it is automatic the variable CLBVH_HAND_OVER ("within", "between", "auto") decides, and
    /// where that leaves it open the profile.
    HandOver hand_over = HandOver::automatic;
};

/// A device with its OpenCL context, its queue and the programs built for it. Cheap to copy: copies share everything.
/// Programs are built when a builder is made that needs them, and kept as long as any copy lives. One thread at a time.
class CLBVH_API Context {
public:
    /// Opens the device that pick_device(selector) picks, with a context and an in-order profiling queue of its own.
    /// Throws what pick_device throws; Error(invalid_input) where CLBVH_CACHE is none of auto, on, off, or
    /// CLBVH_HAND_OVER none of auto, within, between; and, unless options.use_profile is off, Error(invalid_input or
    /// io) where CLBVH_PROFILE names a file that is not a profile.
    [[nodiscard]] static Context open(std::string_view selector = {}, const ContextOptions& options = {});

    /// Adopts the caller's queue, in order or out of order, and retains it, its context and its device. Stage device
    /// times are 0 where the queue was made without CL_QUEUE_PROFILING_ENABLE. Throws what open throws of variables.
    [[nodiscard]] static Context adopt(cl_command_queue queue, const ContextOptions& options = {});

    [[nodiscard]] const DeviceInfo& device() const noexcept;
    [[nodiscard]] cl_context opencl_context() const noexcept;
    [[nodiscard]] cl_command_queue opencl_queue() const noexcept;

    /// The profile that stands in for automatic options here, if any.
    [[nodiscard]] const FoundProfile& profile() const noexcept;

    /// True where the lane shape may be the default here: a CPU device that passes a small self-test (run once).
    [[nodiscard]] bool prefers_lane_shape() const;

    /// Runs the self-test of what work groups hand over to each other within a launch, ten million times: some
    /// milliseconds on a GPU, a second on a CPU. Where it is false, HandOver::within_launch gives wrong trees.
    [[nodiscard]] bool passes_hand_over_check() const;

    /// State that the device builders share; private to the library.
    [[nodiscard]] device::Session& session() const noexcept { return *session_; }

private:
    explicit Context(std::shared_ptr<device::Session> session);
    std::shared_ptr<device::Session> session_;
};

}  // namespace clbvh
