// Kernels with a data race and with a read of uninitialised memory, for proving that Oclgrind sees both.

#include <CL/cl.h>

#include <clbvh/device/context.hpp>
#include <cstddef>
#include <cstdlib>
#include <iostream>

namespace {

constexpr const char* kSource = R"(
kernel void race(global uint* out) {
    local uint shared_value[4];
    const size_t i = get_local_id(0);
    shared_value[i] = (uint)i;
    out[i] = shared_value[(i + 1) % 4];  // A barrier is missing before this line.
}

kernel void uninitialised(global uint* out) {
    local uint shared_value[4];
    const size_t i = get_local_id(0);
    out[i] = shared_value[i];
}
)";

void check(cl_int status, const char* call) {
    if (status != CL_SUCCESS) {
        std::cerr << call << " failed with OpenCL error " << status << '\n';
        std::exit(EXIT_FAILURE);
    }
}

void run(cl_program program, cl_command_queue queue, cl_mem out, const char* name) {
    cl_int status = CL_SUCCESS;
    cl_kernel kernel = clCreateKernel(program, name, &status);
    check(status, "clCreateKernel");
    const std::size_t size = 4;
    check(clSetKernelArg(kernel, 0, sizeof out, &out), "clSetKernelArg");
    check(clEnqueueNDRangeKernel(queue, kernel, 1, nullptr, &size, &size, 0, nullptr, nullptr),
          "clEnqueueNDRangeKernel");
    check(clFinish(queue), "clFinish");
    clReleaseKernel(kernel);
}

}  // namespace

int main() {
    const clbvh::Context context = clbvh::Context::open();
    const char* source = kSource;
    cl_int status = CL_SUCCESS;
    cl_program program = clCreateProgramWithSource(context.opencl_context(), 1, &source, nullptr, &status);
    check(status, "clCreateProgramWithSource");
    check(clBuildProgram(program, 0, nullptr, "", nullptr, nullptr), "clBuildProgram");
    cl_mem out = clCreateBuffer(context.opencl_context(), CL_MEM_READ_WRITE, 4 * sizeof(cl_uint), nullptr, &status);
    check(status, "clCreateBuffer");
    run(program, context.opencl_queue(), out, "race");
    run(program, context.opencl_queue(), out, "uninitialised");
    clReleaseMemObject(out);
    clReleaseProgram(program);
}
