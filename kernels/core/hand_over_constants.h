// The sizes of hand_over_check.cl, for the kernel and for the host, which launches it.
#ifndef CLBVH_KERNELS_HAND_OVER_CONSTANTS_H
#define CLBVH_KERNELS_HAND_OVER_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    HAND_OVER_DISTANCES = 9,  // 1, 2, 4 .. groups
    HAND_OVER_GROUPS = 1 << HAND_OVER_DISTANCES,
    HAND_OVER_WORDS = 16,  // of a meeting place: what one side hands over, then what the other does
    HAND_OVER_SENT = 6,    // words of a side that are sent, as of a box
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
