#pragma once

// OpenCL's handles, declared as <CL/cl.h> declares them. The headers of this library need no more of OpenCL: it is for
// the program to include, before them or after, in whichever version (CL_TARGET_OPENCL_VERSION).
// NOLINTBEGIN(bugprone-reserved-identifier, readability-identifier-naming)
using cl_command_queue = struct _cl_command_queue*;
using cl_context = struct _cl_context*;
using cl_event = struct _cl_event*;
using cl_mem = struct _cl_mem*;
// NOLINTEND(bugprone-reserved-identifier, readability-identifier-naming)
