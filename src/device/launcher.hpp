#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <string_view>
#include <vector>

#include "clbvh/core/build_options.hpp"
#include "clbvh/core/build_stats.hpp"
#include "device/session.hpp"

namespace clbvh::device {

/// Enqueues the kernels of one build on the session's queue, stage by stage, and keeps the books: launches, times,
/// progress.
class Launcher {
public:
    Launcher(Session& session, const ProgressCallback& progress);

    /// Ends the stage before, and reports `fraction` of the build done. Throws Error(cancelled) where the callback says
    /// no.
    void begin_stage(std::string_view name, double fraction);

    /// Reports progress within the stage; throws as begin_stage does.
    void report(double fraction);

    /// Enqueues `groups` work groups of `kernel` with `arguments` (buffers and integers) in order.
    template <class... Arguments>
    requires((std::same_as<Arguments, cl::Buffer> ||
              std::integral<Arguments>)&&...) void launch(Kernel& kernel, std::size_t groups,
                                                          const Arguments&... arguments) {
        cl_uint index = 0;
        with_opencl_errors("kernel " + kernel.name, [&] { (kernel.kernel.setArg(index++, arguments), ...); });
        enqueue(kernel, groups);
    }

    /// Waits for all that was enqueued and copies one number from the device.
    [[nodiscard]] std::uint32_t read_uint(const cl::Buffer& buffer);

    /// Books `bytes` that the stage's kernels have to read or write.
    void count_bytes(std::uint64_t bytes) { stats_.stages.back().bytes_moved += bytes; }

    /// Books one round of clustering on `clusters` clusters.
    void count_iteration(std::uint32_t clusters);

    /// Waits for the device and returns the statistics.
    [[nodiscard]] BuildStats finish();

    [[nodiscard]] Session& session() noexcept { return session_; }

private:
    using Clock = std::chrono::steady_clock;

    void enqueue(Kernel& kernel, std::size_t groups);
    void end_stage();
    void add_device_times();

    Session& session_;
    const ProgressCallback& progress_;
    BuildStats stats_;
    double reported_ = 0.0;
    Clock::time_point build_begin_ = Clock::now();
    Clock::time_point stage_begin_ = build_begin_;
    std::vector<std::pair<std::size_t, cl::Event>> events_;  // stage, kernel execution
};

}  // namespace clbvh::device
