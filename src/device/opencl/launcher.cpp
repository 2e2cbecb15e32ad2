#include "device/opencl/launcher.hpp"

#include <algorithm>
#include <utility>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

double milliseconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

bool is_out_of_order(const cl::CommandQueue& queue) {
    return (queue.getInfo<CL_QUEUE_PROPERTIES>() & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) != 0;
}

}  // namespace

Launcher::Launcher(Session& session, const ProgressCallback& progress)
    : session_(session),
      queue_(session.queue()),
      out_of_order_(is_out_of_order(queue_)),
      profiles_(session.profiles()),
      progress_(&progress) {}

Launcher::Launcher(Session& session, cl::CommandQueue queue, std::vector<cl::Event> wait_list)
    : session_(session),
      queue_(std::move(queue)),
      waits_(std::move(wait_list)),
      out_of_order_(is_out_of_order(queue_)),
      profiles_(false) {}

template <class Enqueue>
void Launcher::enqueue_next(Enqueue&& enqueue) {
    cl::Event event;
    enqueue(waits_.empty() ? nullptr : &waits_, profiles_ || out_of_order_ ? &event : nullptr);
    waits_.clear();
    if (out_of_order_) waits_.push_back(event);
    if (profiles_) events_.emplace_back(stats_.stages.size() - 1, std::move(event));
}

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
    if (progress_ != nullptr && *progress_ && !(*progress_)({stats_.stages.back().name, reported_})) {
        with_opencl_errors("cancelling", [&] { queue_.finish(); });
        throw Error(ErrorCode::cancelled, "the build was cancelled in stage " + stats_.stages.back().name);
    }
}

void Launcher::enqueue(Kernel& kernel, std::size_t groups) {
    with_opencl_errors("kernel " + kernel.name, [&] {
        enqueue_next([&](const std::vector<cl::Event>* waits, cl::Event* event) {
            queue_.enqueueNDRangeKernel(kernel.kernel, cl::NullRange, cl::NDRange(groups * kernel.work_group_size),
                                        cl::NDRange(kernel.work_group_size), waits, event);
        });
    });
    ++stats_.stages.back().launches;
    ++stats_.launches;
}

void Launcher::read_uints(const cl::Buffer& buffer, std::span<std::uint32_t> out) {
    with_opencl_errors("reading counts", [&] {
        queue_.enqueueReadBuffer(buffer, CL_TRUE, 0, out.size_bytes(), out.data(), waits_.empty() ? nullptr : &waits_);
    });
    waits_.clear();
}

void Launcher::on_host(const cl::Buffer& buffer, std::size_t bytes, const std::function<void(void*)>& work) {
    void* const mapped = with_opencl_errors("reading what was built", [&] {
        return queue_.enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes,
                                       waits_.empty() ? nullptr : &waits_);
    });
    waits_.clear();
    const auto unmap = [&] {
        with_opencl_errors("writing what was built", [&] {
            enqueue_next([&](const std::vector<cl::Event>* waits, cl::Event* event) {
                queue_.enqueueUnmapMemObject(buffer, mapped, waits, event);
            });
        });
    };
    try {
        work(mapped);
    } catch (...) {
        unmap();
        throw;
    }
    unmap();
}

void Launcher::copy_uint(const cl::Buffer& from, std::uint64_t from_offset, const cl::Buffer& to,
                         std::uint64_t offset) {
    with_opencl_errors("copying a count", [&] {
        enqueue_next([&](const std::vector<cl::Event>* waits, cl::Event* event) {
            queue_.enqueueCopyBuffer(from, to, from_offset, offset, sizeof(cl_uint), waits, event);
        });
    });
}

void Launcher::clear_uints(const cl::Buffer& to, std::uint64_t offset, std::uint64_t count) {
    with_opencl_errors("clearing counts", [&] {
        enqueue_next([&](const std::vector<cl::Event>* waits, cl::Event* event) {
            queue_.enqueueFillBuffer(to, cl_uint{0}, offset, count * sizeof(cl_uint), waits, event);
        });
    });
}

void Launcher::hand_over_end(cl_event* event) {
    if (event == nullptr) return;
    with_opencl_errors("marking the end of a build", [&] {
        cl::Event end;
        queue_.enqueueMarkerWithWaitList(waits_.empty() ? nullptr : &waits_, &end);
        clRetainEvent(end());
        *event = end();
    });
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
        queue_.finish();
        end_stage();
        stats_.build_ms = milliseconds(Clock::now() - build_begin_);
        add_device_times();
        return std::move(stats_);
    });
}

}  // namespace clbvh::device
