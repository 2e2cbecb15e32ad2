// Shared by the host and the clusterings' kernels.
#ifndef CLBVH_KERNELS_CLUSTER_CONSTANTS_H
#define CLBVH_KERNELS_CLUSTER_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    RECORD_FLOATS = 8,  // of an inner cluster, see cluster.clh
    COUNTS_KEPT = 64,   // of iterations, see iteration.clh
    // Steps from a leaf of the Morton tree to its root, and one more: borders have one of 96 levels.
    MOST_STEPS = 97,
    CLIMB_BYTES = 12,  // where a work item stands between two steps
    // H-PLOC: clusters that are measured against each other at once, and most lists that a piece leaves. Borders have
    // one of 96 levels, the array's ends one more; between the lists of a piece they rise, then fall.
    PLACES = 32,
    HPLOC_CLUSTER_FLOATS = 8,
    LEAST_PIECE_LENGTH = 1024,
    PACKED_LEAF_BITS = 28,  // of a leaf's number, in the lane shape, where leaves may have several primitives
    MOST_LISTS = 2 * 97,
    // LBVH: clusters that a piece leaves. Between them no border is deeper than both its neighbours (it would have been
    // merged), so their levels rise, then fall: at most two runs of 64 + 32 different levels.
    MOST_PENDING = 196,
    PENDING_BYTES = 64,  // of each
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
