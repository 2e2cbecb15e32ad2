#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clbvh/device/context.hpp"
#include "clbvh/device/device.hpp"
#include "device/opencl/opencl.hpp"
#include "device/opencl/program_cache.hpp"

namespace clbvh::device {

/// A kernel file as it is to be compiled.
struct ProgramSpec {
    std::string_view file;  ///< of kernels/; the text lives as long as the library
    std::size_t work_group_size = 1;
    std::string options;  ///< " -D NAME=VALUE ..." beside WORK_GROUP_SIZE
};

/// A kernel that is ready to be launched.
struct Kernel {
    cl::Kernel kernel;
    std::string name;
    std::size_t work_group_size = 1;
};

/// A device, its context and queue, and what was built for it. What Context shares among its copies.
class Session {
public:
    explicit Session(const DeviceInfo& info, const ContextOptions& options = {});
    explicit Session(cl_command_queue queue, const ContextOptions& options = {});

    [[nodiscard]] const DeviceInfo& info() const noexcept { return info_; }
    [[nodiscard]] const cl::Context& context() const noexcept { return context_; }
    [[nodiscard]] const cl::CommandQueue& queue() const noexcept { return queue_; }
    [[nodiscard]] bool profiles() const noexcept { return profiles_; }

    /// Values that replace automatic options.
    [[nodiscard]] const FoundProfile& profile() const noexcept { return profile_; }

    /// Builds those of the programs that are not there yet, on several threads. Files of one group can be one program:
    /// with joins_programs(), those with the same options are.
    /// Throws Error(device_failure) with the build log where one does not build.
    void prepare(std::initializer_list<std::span<const ProgramSpec>> groups);

    /// Kernel `name` of a program, which is built here where prepare() did not. Throws what prepare() throws.
    Kernel& kernel(const ProgramSpec& program, std::string_view name);
    Kernel& kernel(std::string_view file, std::string_view name, std::size_t work_group_size,
                   const std::string& options) {
        return kernel(ProgramSpec{file, work_group_size, options}, name);
    }

    /// Programs that were built or loaded so far.
    [[nodiscard]] std::size_t program_count() const noexcept { return program_count_; }

    /// True where every program costs extra, so that prepare() joins files.
    [[nodiscard]] bool joins_programs() const noexcept;

    /// How groups tell each other things here: never automatic. What the context's options, CLBVH_HAND_OVER or the
    /// profile say; else within launches on CPU devices, and where a self-test, which is run once, passes.
    HandOver hand_over();

    /// False where prefers_lane_shape() is certain to be.
    [[nodiscard]] bool may_prefer_lane_shape() const noexcept;
    /// True for a CPU device on which kernels with one work item a group pass a small self-test.
    bool prefers_lane_shape();

private:
    /// Files that become one program.
    struct Batch {
        std::vector<std::string_view> files;
        std::string options;
    };

    void load_settings(const ContextOptions& options);
    [[nodiscard]] std::string all_options(const ProgramSpec& program) const;
    [[nodiscard]] std::vector<Batch> batches_of(std::initializer_list<std::span<const ProgramSpec>> groups) const;
    [[nodiscard]] cl::Program build_program(const Batch& batch) const;

    DeviceInfo info_;
    cl::Device device_;
    cl::Context context_;
    cl::CommandQueue queue_;
    bool profiles_ = true;
    ProgramCache program_cache_;
    FoundProfile profile_;
    std::map<std::string, cl::Program, std::less<>> programs_;  // by file and options
    std::size_t program_count_ = 0;
    std::map<std::string, Kernel, std::less<>> kernels_;
    std::optional<bool> lane_shape_works_;
    std::string language_options_;
    HandOver hand_over_ = HandOver::automatic;
};

}  // namespace clbvh::device
