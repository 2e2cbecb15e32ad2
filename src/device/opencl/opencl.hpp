#pragma once

#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#include <CL/opencl.hpp>

#include <string>
#include <string_view>
#include <utility>

namespace clbvh::device {

/// Throws the clbvh::Error that stands for a failed OpenCL call: its name and error code, and `detail` (a kernel, a
/// size).
[[noreturn]] void throw_opencl_error(const cl::Error& error, std::string_view detail);

/// Runs `body`; a failed OpenCL call inside becomes a clbvh::Error with `detail`.
template <class Body>
decltype(auto) with_opencl_errors(std::string_view detail, Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (const cl::Error& error) {
        throw_opencl_error(error, detail);
    }
}

}  // namespace clbvh::device
