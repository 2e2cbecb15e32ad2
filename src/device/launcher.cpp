#include "device/launcher.hpp"

#include <algorithm>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

double milliseconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

Launcher::Launcher(Session& session, const ProgressCallback& progress) : session_(session), progress_(progress) {}

void Launcher::begin_stage(std::string_view name, double fraction) {
    end_stage();
    stats_.stages.push_back({std::string(name), 0.0, 0.0, 0});
    stage_begin_ = Clock::now();
    report(fraction);
}

void Launcher::end_stage() {
    if (!stats_.stages.empty()) {
        stats_.stages.back().host_ms = milliseconds(Clock::now() - stage_begin_);
    }
}

void Launcher::report(double fraction) {
    reported_ = std::clamp(fraction, reported_, 1.0);
    if (progress_ && !progress_({stats_.stages.back().name, reported_})) {
        with_opencl_errors("cancelling", [&] { session_.queue().finish(); });
        throw Error(ErrorCode::cancelled, "the build was cancelled in stage " + stats_.stages.back().name);
    }
}

void Launcher::enqueue(Kernel& kernel, std::size_t groups) {
    with_opencl_errors("kernel " + kernel.name, [&] {
        cl::Event event;
        session_.queue().enqueueNDRangeKernel(
            kernel.kernel, cl::NullRange, cl::NDRange(groups * kernel.work_group_size),
            cl::NDRange(kernel.work_group_size), nullptr, session_.profiles() ? &event : nullptr);
        if (session_.profiles()) {
            events_.emplace_back(stats_.stages.size() - 1, std::move(event));
        }
    });
    ++stats_.stages.back().launches;
    ++stats_.launches;
}

std::uint32_t Launcher::read_uint(const cl::Buffer& buffer) {
    std::uint32_t value = 0;
    with_opencl_errors("reading a count",
                       [&] { session_.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, sizeof(value), &value); });
    return value;
}

void Launcher::count_iteration(std::uint32_t clusters) {
    ++stats_.iterations;
    stats_.clusters_per_iteration.push_back(clusters);
}

void Launcher::add_device_times() {
    for (const auto& [stage, event] : events_) {
        const cl_ulong begin = event.getProfilingInfo<CL_PROFILING_COMMAND_START>();
        const cl_ulong end = event.getProfilingInfo<CL_PROFILING_COMMAND_END>();
        stats_.stages[stage].device_ms += static_cast<double>(end - begin) * 1e-6;
    }
}

BuildStats Launcher::finish() {
    return with_opencl_errors("finishing a build", [&] {
        session_.queue().finish();
        end_stage();
        stats_.build_ms = milliseconds(Clock::now() - build_begin_);
        add_device_times();
        return std::move(stats_);
    });
}

}  // namespace clbvh::device
