// Shared by the host and all kernels.
#ifndef CLBVH_KERNELS_CORE_CONSTANTS_H
#define CLBVH_KERNELS_CORE_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    BOX_FLOATS = 6,  // of a box in global memory: lower x y z, upper x y z
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
