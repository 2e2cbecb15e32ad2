#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "clbvh/core/build_stats.hpp"
#include "device/opencl/session.hpp"

namespace clbvh::device {

/// A buffer, an integer, a float, or a structure of such numbers that a kernel's header defines for both languages.
template <class T>
concept KernelArgument = std::same_as<T, cl::Buffer> || std::same_as<T, float> || std::integral<T> ||
    (std::is_aggregate_v<T>&& std::is_trivially_copyable_v<T>);

/// Enqueues the kernels of one build, stage by stage, each to run when the one before is done, whatever the order of
/// the queue. Keeps the books: launches, times, progress.
class Launcher {
public:
    /// On the session's queue.
    Launcher(Session& session, const ProgressCallback& progress);
    /// On a queue of the caller's, behind the events in `wait_list`. Takes no times and reports no progress.
    Launcher(Session& session, cl::CommandQueue queue, std::vector<cl::Event> wait_list);

    /// Ends the stage before, and reports `fraction` of the build done. Throws Error(cancelled) where the callback says
    /// no.
    void begin_stage(std::string_view name, double fraction);

    /// Reports progress within the stage; throws as begin_stage does.
    void report(double fraction);

    /// Enqueues `groups` work groups of `kernel` with `arguments` in order.
    template <KernelArgument... Arguments>
    void launch(Kernel& kernel, std::size_t groups, const Arguments&... arguments) {
        cl_uint index = 0;
        with_opencl_errors("kernel " + kernel.name, [&] { (kernel.kernel.setArg(index++, arguments), ...); });
        enqueue(kernel, groups);
    }

    /// Waits for all that was enqueued and copies the first numbers of `buffer` from the device.
    void read_uints(const cl::Buffer& buffer, std::span<std::uint32_t> out);
    [[nodiscard]] std::uint32_t read_uint(const cl::Buffer& buffer) {
        std::uint32_t value = 0;
        read_uints(buffer, {&value, 1});
        return value;
    }

    /// Waits for all that was enqueued, and calls `work` with the first `bytes` of `buffer` for it to read and write.
    void on_host(const cl::Buffer& buffer, std::size_t bytes, const std::function<void(void*)>& work);

    /// Enqueues a copy of the number `from_offset` bytes into `from` to `offset` bytes into `to`.
    void copy_uint(const cl::Buffer& from, std::uint64_t from_offset, const cl::Buffer& to, std::uint64_t offset);

    /// Enqueues that `count` numbers from `offset` bytes into `to` on become 0.
    void clear_uints(const cl::Buffer& to, std::uint64_t offset, std::uint64_t count);

    /// Makes `*event`, where there is one, an event of the caller's that is complete when all that was enqueued is.
    void hand_over_end(cl_event* event);

    /// Books `bytes` that the stage's kernels have to read or write.
    void count_bytes(std::uint64_t bytes) { stats_.stages.back().bytes_moved += bytes; }

    /// Books one round of clustering on `clusters` clusters.
    void count_iteration(std::uint32_t clusters);

    /// Waits for the device and returns the statistics.
    [[nodiscard]] BuildStats finish();

    [[nodiscard]] Session& session() noexcept { return session_; }

private:
    using Clock = std::chrono::steady_clock;

    /// Calls `enqueue` with the events that a command waits for and with where to put its own, null where it needs
    /// none.
    template <class Enqueue>
    void enqueue_next(Enqueue&& enqueue);
    void enqueue(Kernel& kernel, std::size_t groups);
    void end_stage();
    void add_device_times();

    Session& session_;
    cl::CommandQueue queue_;
    std::vector<cl::Event> waits_;  // of the next command
    bool out_of_order_;
    bool profiles_;
    const ProgressCallback* progress_ = nullptr;
    BuildStats stats_;
    double reported_ = 0.0;
    Clock::time_point build_begin_ = Clock::now();
    Clock::time_point stage_begin_ = build_begin_;
    std::vector<std::pair<std::size_t, cl::Event>> events_;  // stage, kernel execution
};

}  // namespace clbvh::device
