#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <thread>

#include "clbvh/core/build_stats.hpp"

namespace clbvh::host {

/// Keeps the books of one host build, stage by stage: times, progress, cancellation.
class HostStages {
public:
    explicit HostStages(const ProgressCallback& progress);

    /// Ends the stage before. The new one takes the build from fraction `from` to `to` in `work` units, at least 1.
    /// Throws Error(cancelled) where the callback returns false. Not while tasks run.
    void begin(std::string_view name, double from, double to, std::uint64_t work = 1);

    /// Books `work` units of the stage as done, from any thread. Throws Error(cancelled) on every thread once the
    /// callback, which only the thread that made this object calls, has returned false. Cheap: tasks call it at every
    /// piece of work that takes some microseconds.
    void advance(std::uint64_t work);

    /// Ends the last stage and returns the times.
    [[nodiscard]] BuildStats finish();

private:
    using Clock = std::chrono::steady_clock;

    void end_stage();
    void report(double fraction);

    const ProgressCallback& progress_;
    std::thread::id thread_ = std::this_thread::get_id();
    BuildStats stats_;
    Clock::time_point build_begin_ = Clock::now();
    Clock::time_point stage_begin_ = build_begin_;
    Clock::time_point last_report_ = build_begin_;
    double from_ = 0.0;
    double to_ = 0.0;
    std::uint64_t work_ = 1;
    double reported_ = 0.0;
    std::atomic<std::uint64_t> done_ = 0;
    std::atomic<bool> cancelled_ = false;
};

}  // namespace clbvh::host
