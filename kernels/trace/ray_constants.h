// Shared by kernels, the host's tracer and its users: clbvh/core/ray.hpp and clbvh/trace/box_tests.hpp, which are
// installed without kernels, state them again, and a test compares.
#ifndef CLBVH_KERNELS_RAY_CONSTANTS_H
#define CLBVH_KERNELS_RAY_CONSTANTS_H

// Hit::primitive of a ray that hits nothing: kNoPrimitive.
#define NO_PRIMITIVE 0xFFFFFFFFu

// 1 + 2^-18: kBoxSlack.
#define BOX_SLACK 1.000003814697265625f

#endif
