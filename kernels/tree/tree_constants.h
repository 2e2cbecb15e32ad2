// Shared by the host and the kernels that work on finished trees.
#ifndef CLBVH_KERNELS_TREE_CONSTANTS_H
#define CLBVH_KERNELS_TREE_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    SLOTS_PER_GROUP = 4096,  // that a work group of a pass over all slots takes
};

// Words of reinsertion's control.
enum {
    IS_DONE = 0,       // no pass has anything left to do
    CANDIDATES = 1,    // of this pass
    THRESHOLD = 2,     // rank of which only some are taken, and all above it
    AT_THRESHOLD = 3,  // nodes of that rank
    QUOTA = 4,         // how many of them are taken
    IS_UNDONE = 5,     // the pass's moves are taken back
    PART = 6,          // float: of all nodes, how many are candidates
    SCALE = 7,         // float: units of area, see in_units()
    CONTROL_WORDS = 16,
};

enum {
    // Ranks are the leading bits of floats above 0: sign, exponent and the first bits of the mantissa, which tell
    // floats apart that differ by an eighth.
    RANK_SHIFT = 20,
    RANKS = (1 << (31 - RANK_SHIFT)) + 1,
    MOST_PART_DIVISOR = 10,  // a pass tries at most one node of so many
    FOUND_BYTES = 16,        // of Found and of Change, see reinsert_state.clh
    CHANGE_BYTES = 16,
};

enum {
    SUBTREE_BITS = 8,  // treelets: a subtree of level 0 has fewer leaves than 2^SUBTREE_BITS
    TREELETS = 16,     // that a work item of the lane shape takes at a time
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
