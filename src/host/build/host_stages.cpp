#include "host/build/host_stages.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/error.hpp"

namespace clbvh::host {
namespace {

double milliseconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

HostStages::HostStages(const ProgressCallback& progress) : progress_(progress) {}

void HostStages::begin(std::string_view name, double from, double to, std::uint64_t work) {
    end_stage();
    stats_.stages.push_back({std::string(name), 0.0, 0.0, 0});
    from_ = from;
    to_ = to;
    work_ = std::max<std::uint64_t>(work, 1);
    done_ = 0;
    report(from);
}

void HostStages::advance(std::uint64_t work) {
    constexpr std::chrono::milliseconds report_interval{20};
    const std::uint64_t done = done_.fetch_add(work, std::memory_order_relaxed) + work;
    if (progress_ && std::this_thread::get_id() == thread_ && Clock::now() - last_report_ >= report_interval) {
        const double part = std::min(static_cast<double>(done) / static_cast<double>(work_), 1.0);
        report(from_ + part * (to_ - from_));
    }
    if (cancelled_.load(std::memory_order_relaxed)) {
        throw Error(ErrorCode::cancelled, "the progress callback cancelled the build");
    }
}

BuildStats HostStages::finish() {
    end_stage();
    stats_.build_ms = milliseconds(Clock::now() - build_begin_);
    return std::move(stats_);
}

void HostStages::end_stage() {
    const Clock::time_point now = Clock::now();
    if (!stats_.stages.empty()) stats_.stages.back().host_ms = milliseconds(now - stage_begin_);
    stage_begin_ = now;
}

void HostStages::report(double fraction) {
    if (!progress_) return;
    last_report_ = Clock::now();
    reported_ = std::max(reported_, fraction);
    if (progress_({stats_.stages.back().name, reported_})) return;
    cancelled_ = true;
    throw Error(ErrorCode::cancelled, "the progress callback cancelled the build");
}

}  // namespace clbvh::host
