// What kernels that trace and the host both know.
#ifndef CLBVH_KERNELS_TRACE_CONSTANTS_H
#define CLBVH_KERNELS_TRACE_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    INPUT_LEAF_ORDER = 5,  // beside the forms of build_constants.h: a layout's rows
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
