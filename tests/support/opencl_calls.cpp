#include "support/opencl_calls.hpp"

#include <CL/cl.h>
#include <dlfcn.h>

#include <atomic>

namespace clbvh::test {
namespace {

struct Counters {
    std::atomic<std::size_t> buffers{0}, sub_buffers{0}, programs{0}, launches{0}, waits{0}, copied{0};
};
Counters counters;

/// Buffers that are still made; negative: all are.
std::atomic<long> buffers_left{-1};

bool may_make_buffer() {
    if (buffers_left.load() < 0) return true;
    return buffers_left.load() > 0 && buffers_left.fetch_sub(1) > 0;
}

cl_mem fail(cl_int* error) {
    if (error != nullptr) *error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return nullptr;
}

/// The loader's own function of this name, which the definition below stands before.
template <typename Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

OpenClCalls opencl_calls() {
    return {counters.buffers,  counters.sub_buffers, counters.programs,
            counters.launches, counters.waits,       counters.copied};
}

void allow_buffers(long allowed) {
    buffers_left = allowed;
}
void allow_buffers() {
    buffers_left = -1;
}

}  // namespace clbvh::test

using clbvh::test::counters;
using clbvh::test::fail;
using clbvh::test::may_make_buffer;
using clbvh::test::next;

extern "C" {

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host, cl_int* error) {
    static auto* const real = next<decltype(clCreateBuffer)>("clCreateBuffer");
    ++counters.buffers;
    if ((flags & CL_MEM_COPY_HOST_PTR) != 0) counters.copied += size;
    if (!may_make_buffer()) return fail(error);
    return real(context, flags, size, host, error);
}

cl_mem clCreateImage(cl_context context, cl_mem_flags flags, const cl_image_format* format, const cl_image_desc* desc,
                     void* host, cl_int* error) {
    static auto* const real = next<decltype(clCreateImage)>("clCreateImage");
    ++counters.buffers;
    return real(context, flags, format, desc, host, error);
}

cl_mem clCreateSubBuffer(cl_mem buffer, cl_mem_flags flags, cl_buffer_create_type type, const void* info,
                         cl_int* error) {
    static auto* const real = next<decltype(clCreateSubBuffer)>("clCreateSubBuffer");
    ++counters.sub_buffers;
    if (!may_make_buffer()) return fail(error);
    return real(buffer, flags, type, info, error);
}

cl_program clCreateProgramWithSource(cl_context context, cl_uint count, const char** strings, const size_t* lengths,
                                     cl_int* error) {
    static auto* const real = next<decltype(clCreateProgramWithSource)>("clCreateProgramWithSource");
    ++counters.programs;
    return real(context, count, strings, lengths, error);
}

cl_program clCreateProgramWithBinary(cl_context context, cl_uint device_count, const cl_device_id* devices,
                                     const size_t* lengths, const unsigned char** binaries, cl_int* status,
                                     cl_int* error) {
    static auto* const real = next<decltype(clCreateProgramWithBinary)>("clCreateProgramWithBinary");
    ++counters.programs;
    return real(context, device_count, devices, lengths, binaries, status, error);
}

// NOLINTBEGIN(readability-function-size): the parameters are OpenCL's.
cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t* offset,
                              const size_t* global, const size_t* local, cl_uint wait_count, const cl_event* wait_list,
                              cl_event* event) {
    static auto* const real = next<decltype(clEnqueueNDRangeKernel)>("clEnqueueNDRangeKernel");
    ++counters.launches;
    return real(queue, kernel, dimensions, offset, global, local, wait_count, wait_list, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
                           void* out, cl_uint wait_count, const cl_event* wait_list, cl_event* event) {
    static auto* const real = next<decltype(clEnqueueReadBuffer)>("clEnqueueReadBuffer");
    counters.waits += blocking != CL_FALSE ? 1 : 0;
    return real(queue, buffer, blocking, offset, size, out, wait_count, wait_list, event);
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
                            const void* in, cl_uint wait_count, const cl_event* wait_list, cl_event* event) {
    static auto* const real = next<decltype(clEnqueueWriteBuffer)>("clEnqueueWriteBuffer");
    counters.waits += blocking != CL_FALSE ? 1 : 0;
    counters.copied += size;
    return real(queue, buffer, blocking, offset, size, in, wait_count, wait_list, event);
}

void* clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags, size_t offset,
                         size_t size, cl_uint wait_count, const cl_event* wait_list, cl_event* event, cl_int* error) {
    static auto* const real = next<decltype(clEnqueueMapBuffer)>("clEnqueueMapBuffer");
    counters.waits += blocking != CL_FALSE ? 1 : 0;
    return real(queue, buffer, blocking, flags, offset, size, wait_count, wait_list, event, error);
}
// NOLINTEND(readability-function-size)

cl_int clFinish(cl_command_queue queue) {
    static auto* const real = next<decltype(clFinish)>("clFinish");
    ++counters.waits;
    return real(queue);
}

cl_int clWaitForEvents(cl_uint count, const cl_event* events) {
    static auto* const real = next<decltype(clWaitForEvents)>("clWaitForEvents");
    ++counters.waits;
    return real(count, events);
}

}  // extern "C"
