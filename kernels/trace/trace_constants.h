// What kernels that trace and the host both know.
#ifndef CLBVH_KERNELS_TRACE_CONSTANTS_H
#define CLBVH_KERNELS_TRACE_CONSTANTS_H
#ifdef __cplusplus
#include <cstdint>
namespace clbvh::kernels {
using uint = std::uint32_t;
using ulong = std::uint64_t;
#endif

enum {
    INPUT_LEAF_ORDER = 5,  // beside the forms of build_constants.h: a layout's rows
};

// Where rays and their results begin in their buffers, in bytes, and how many there are.
typedef struct {
    ulong rays, results, counts, control;
    uint ray_count, has_counts;
} RaysPlace;

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
