#include "measure/copy_contestant.hpp"

#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/opencl.hpp>

#include <algorithm>
#include <clbvh/core/error.hpp>
#include <clbvh/layout/layout_array.hpp>
#include <cstddef>
#include <string>
#include <utility>

#include "cli/stopwatch.hpp"

namespace clbvh::tool {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{128} << 20;
constexpr std::uint64_t kGranularity = 4096;
constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 20;
constexpr std::uint64_t kCpuVectorBytes = 64;
constexpr std::uint64_t kVectorBytes = 16;
constexpr cl_uint kPattern = 0x9e3779b9;

// in      from [count] vectors
// out     to   [count] the same
// launch  on a CPU: ceil(count / piece) work items, groups of 1; else count work items
constexpr const char* kSource = R"(
#if ON_CPU
#ifndef __has_builtin
#define __has_builtin(name) 0
#endif
#define READ_AHEAD 16

kernel void copy(global const ulong8* restrict from, global ulong8* restrict to, uint piece, uint count) {
    const size_t begin = get_global_id(0) * (size_t)piece;
    const size_t end = min(begin + piece, (size_t)count);
    for (size_t i = begin; i < end; ++i) {
#if __has_builtin(__builtin_prefetch)
        __builtin_prefetch((const global void*)&from[i + READ_AHEAD]);
#endif
#if __has_builtin(__builtin_nontemporal_store)
        __builtin_nontemporal_store(from[i], &to[i]);
#else
        to[i] = from[i];
#endif
    }
}

#else

kernel void copy(global const uint4* restrict from, global uint4* restrict to) {
    to[get_global_id(0)] = from[get_global_id(0)];
}
#endif
)";

/// Runs `body`; a failed OpenCL call inside becomes a clbvh::Error.
template <typename Body>
decltype(auto) with_opencl_errors(Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const cl::Error& error) {
        const bool is_memory = error.err() == CL_MEM_OBJECT_ALLOCATION_FAILURE ||
                               error.err() == CL_OUT_OF_HOST_MEMORY || error.err() == CL_OUT_OF_RESOURCES;
        throw Error(is_memory ? ErrorCode::out_of_memory : ErrorCode::device_failure,
                    std::string("the copy that memory is measured by: ") + error.what() + " failed with " +
                        std::to_string(error.err()));
    }
}

/// An eighth of the memory is the most that both buffers may take.
std::uint64_t copy_bytes(const DeviceInfo& device) {
    const std::uint64_t most = std::min({kMostBytes, device.max_allocation_bytes, device.global_memory_bytes / 16});
    return std::max(most / kGranularity, std::uint64_t{1}) * kGranularity;
}

}  // namespace

struct CopyContestant::Device {
    explicit Device(const Context& chosen)
        : context(chosen),
          bytes(copy_bytes(chosen.device())),
          opencl_context(chosen.opencl_context(), true),
          queue(chosen.opencl_queue(), true),
          on_cpu(chosen.device().type == DeviceType::cpu),
          from(make_buffer(memory_of_from)),
          to(make_buffer(memory_of_to)) {
        cl::Program program(opencl_context, std::string(kSource));
        program.build(on_cpu ? "-cl-std=CL1.2 -D ON_CPU=1" : "-cl-std=CL1.2 -D ON_CPU=0");
        kernel = cl::Kernel(program, "copy");
        kernel.setArg(0, from);
        kernel.setArg(1, to);
        if (on_cpu) {
            kernel.setArg(2, static_cast<cl_uint>(kPieceBytes / kCpuVectorBytes));
            kernel.setArg(3, static_cast<cl_uint>(bytes / kCpuVectorBytes));
            items = cl::NDRange((bytes + kPieceBytes - 1) / kPieceBytes);
            group = cl::NDRange(1);
        } else {
            items = cl::NDRange(bytes / kVectorBytes);
        }
        queue.enqueueFillBuffer(from, kPattern, 0, bytes);
        queue.finish();
    }

    /// On a CPU in huge pages, as the builders' buffers are; `memory` then owns it.
    cl::Buffer make_buffer(LayoutArray<std::byte>& memory) const {
        if (!on_cpu) return {opencl_context, CL_MEM_READ_WRITE, bytes};
        memory.resize_for_overwrite(bytes);
        return {opencl_context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory.data()};
    }

    /// Milliseconds of one copy: the device's own, or the host's where the queue does not profile.
    [[nodiscard]] double copy() const {
        const Stopwatch stopwatch;
        cl::Event event;
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, items, group, nullptr, &event);
        event.wait();
        const double host_ms = stopwatch.milliseconds();
        if ((queue.getInfo<CL_QUEUE_PROPERTIES>() & CL_QUEUE_PROFILING_ENABLE) == 0) return host_ms;
        const cl_ulong begin = event.getProfilingInfo<CL_PROFILING_COMMAND_START>();
        const cl_ulong end = event.getProfilingInfo<CL_PROFILING_COMMAND_END>();
        return static_cast<double>(end - begin) * 1e-6;
    }

    Context context;  // keeps the device open
    std::uint64_t bytes;
    cl::Context opencl_context;
    cl::CommandQueue queue;
    bool on_cpu;
    LayoutArray<std::byte> memory_of_from;
    LayoutArray<std::byte> memory_of_to;
    cl::Buffer from;
    cl::Buffer to;
    cl::Kernel kernel;
    cl::NDRange items;
    cl::NDRange group = cl::NullRange;
};

CopyContestant::CopyContestant(const Context& context)
    : device_(with_opencl_errors([&] { return std::make_unique<Device>(context); })) {}

CopyContestant::~CopyContestant() = default;

void CopyContestant::run(bool counted) {
    const double milliseconds = with_opencl_errors([&] { return device_->copy(); });
    const double moved = 2.0 * static_cast<double>(device_->bytes);
    if (counted) gb_per_s_.push_back(moved / milliseconds * 1e-6);
}

bool CopyContestant::is_right() const {
    std::vector<cl_uint> values(device_->bytes / sizeof(cl_uint));
    with_opencl_errors(
        [&] { device_->queue.enqueueReadBuffer(device_->to, CL_TRUE, 0, device_->bytes, values.data()); });
    return std::ranges::all_of(values, [](cl_uint value) { return value == kPattern; });
}

}  // namespace clbvh::tool
