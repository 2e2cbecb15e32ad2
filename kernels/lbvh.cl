// LBVH: the binary tree that sorted Morton codes imply, with boxes, in one bottom-up pass. Every border between
// neighbouring positions is one inner node, numbered by the position behind it (node.clh).
//
// prepare        group shape: what climb exchanges with starts as NOT_REACHED and zeros
//   out    reached [leaf_count], nodes
//   launch ceil(leaf_count / WORK_GROUP_SIZE) groups
// climb          group shape: one work item a leaf; the second to reach a node goes on (Apetrei 2014)
//   in     codes, leaves [leaf_count ..]   inout  reached   out  nodes, root_reference
//   [1] launch ceil(leaf_count / WORK_GROUP_SIZE) groups
// build_pieces   lane shape: one work item a contiguous piece of the leaves, with a stack instead of atomics; clusters
// that
//                its borders leave incomplete go to pending [groups * MAX_PENDING], pending_counts [groups]
// join_pieces    lane shape: one work item finishes with the pending clusters of all pieces
// The trees are the same.
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "morton_split.clh"

#if LANE_SHAPE

// Between the pending clusters of a piece no border is deeper than both its neighbours (it would have been merged), so
// their levels rise, then fall: at most two runs of 64 + 32 different levels.
#define MAX_PENDING 196

typedef struct {
    Box box;
    uint reference;
    uint first;
} PendingCluster;

// Puts `cluster` on the stack of neighbouring clusters, then merges at the top while the border between the two is the
// deepest around. `end` is the position behind the cluster. Returns the stack's new size.
static inline uint push_cluster(PendingCluster* stack, uint size, PendingCluster cluster, uint end,
                                global const ulong* codes, global float* nodes, uint leaf_count) {
    const int right_level = border_level(codes, end, leaf_count);
    while (size > 0) {
        const PendingCluster left = stack[size - 1];
        const int level = border_level(codes, cluster.first, leaf_count);
        if (level > right_level || level > border_level(codes, left.first, leaf_count)) {
            break;
        }
        const uint slot = cluster.first;
        write_sibling_pair(nodes, slot, left.box, left.reference, cluster.box, cluster.reference, leaf_count);
        cluster.box = merge_boxes(left.box, cluster.box);
        cluster.reference = leaf_count + slot;
        cluster.first = left.first;
        --size;
    }
    stack[size] = cluster;
    return size + 1;
}

KERNEL void build_pieces(global const ulong* codes, global const float* leaves, global const uint* leaf_count_in,
                         uint piece_length, global float* nodes, global PendingCluster* pending,
                         global uint* pending_counts) {
    const uint leaf_count = *leaf_count_in;
    const uint begin = min((uint)get_group_id(0) * piece_length, leaf_count);
    const uint end = min(begin + piece_length, leaf_count);
    PendingCluster stack[MAX_PENDING];
    uint size = 0;
    for (uint i = begin; i < end; ++i) {
        const PendingCluster leaf = {load_box(leaves + BOX_FLOATS * (size_t)i), i, i};
        size = push_cluster(stack, size, leaf, i + 1, codes, nodes, leaf_count);
    }
    for (uint k = 0; k < size; ++k) {
        pending[get_group_id(0) * MAX_PENDING + k] = stack[k];
    }
    pending_counts[get_group_id(0)] = size;
}

KERNEL void join_pieces(global const PendingCluster* pending, global const uint* pending_counts, uint piece_count,
                        global const ulong* codes, global const uint* leaf_count_in, global float* nodes,
                        global uint* root_reference) {
    const uint leaf_count = *leaf_count_in;
    PendingCluster stack[MAX_PENDING];
    uint size = 0;
    PendingCluster next = pending[0];
    int first_one = 1;
    for (uint piece = 0; piece < piece_count; ++piece) {
        for (uint k = 0; k < pending_counts[piece]; ++k) {
            const PendingCluster following = pending[piece * MAX_PENDING + k];
            if (!first_one) {
                size = push_cluster(stack, size, next, following.first, codes, nodes, leaf_count);
            }
            next = following;
            first_one = 0;
        }
    }
    size = push_cluster(stack, size, next, leaf_count, codes, nodes, leaf_count);
    *root_reference = stack[0].reference;
}

#else

#define NOT_REACHED 0xffffffffu

KERNEL void prepare(global const uint* leaf_count_in, global uint* reached, global float* nodes) {
    const uint leaf_count = *leaf_count_in;
    const size_t slot = get_global_id(0);
    if (slot < leaf_count) {
        reached[slot] = NOT_REACHED;
        vstore16((float16)(0.0f), slot, nodes);
    }
}

// What one work item tells another of a different group goes through atomics on every word: OpenCL 1.2 promises nothing
// of plain stores and loads between groups within a launch. The fence orders them before the exchange that announces
// them.
static inline void publish_node(global uint* node, Box box, uint reference, uint leaf_count) {
    atomic_xchg(node + 0, as_uint(box.lower_x));
    atomic_xchg(node + 1, as_uint(box.lower_y));
    atomic_xchg(node + 2, as_uint(box.lower_z));
    atomic_xchg(node + 4, as_uint(box.upper_x));
    atomic_xchg(node + 5, as_uint(box.upper_y));
    atomic_xchg(node + 6, as_uint(box.upper_z));
    node[3] = node_first(reference, leaf_count);
    node[7] = node_count(reference, leaf_count);
}

static inline float observe(global uint* word) {
    return as_float(atomic_or(word, 0u));
}

static inline Box observe_box(global uint* node) {
    Box box = {observe(node + 0), observe(node + 1), observe(node + 2),
               observe(node + 4), observe(node + 5), observe(node + 6)};
    return box;
}

KERNEL void climb(global const ulong* codes, global const float* leaves, global const uint* leaf_count_in,
                  global uint* reached, global uint* nodes, global uint* root_reference) {
    const uint leaf_count = *leaf_count_in;
    const size_t leaf = get_global_id(0);
    if (leaf >= leaf_count) {
        return;
    }
    Box box = load_box(leaves + BOX_FLOATS * leaf);
    uint reference = (uint)leaf;
    uint begin = (uint)leaf;
    uint end = begin + 1;
    while (begin > 0 || end < leaf_count) {
        // The deeper of the two borders is where this node meets its sibling.
        const int is_left = border_level(codes, end, leaf_count) < border_level(codes, begin, leaf_count);
        const uint slot = is_left ? end : begin;
        publish_node(nodes + 16 * (size_t)slot + (is_left ? 0 : 8), box, reference, leaf_count);
        mem_fence(CLK_GLOBAL_MEM_FENCE);
        const uint sibling_border = atomic_xchg(reached + slot, is_left ? begin : end);
        if (sibling_border == NOT_REACHED) {
            return;
        }
        mem_fence(CLK_GLOBAL_MEM_FENCE);
        box = merge_boxes(box, observe_box(nodes + 16 * (size_t)slot + (is_left ? 8 : 0)));
        reference = leaf_count + slot;
        begin = is_left ? begin : sibling_border;
        end = is_left ? sibling_border : end;
    }
    *root_reference = reference;
}

#endif
