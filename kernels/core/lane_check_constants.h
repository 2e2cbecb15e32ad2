// The sizes of lane_shape_check.cl, for the kernel and for the host, which computes the same.
#ifndef CLBVH_KERNELS_LANE_CHECK_CONSTANTS_H
#define CLBVH_KERNELS_LANE_CHECK_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    CHECK_LENGTH = 64,
    CHECK_ROWS = 16,
    CHECK_STRIDE = CHECK_LENGTH + 32,
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
