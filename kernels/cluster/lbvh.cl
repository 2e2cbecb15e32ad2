// LBVH: the binary tree that sorted Morton codes imply, with boxes, in one bottom-up pass. Every border between
// neighbouring positions is one inner node, numbered by the position behind it (node.clh).
//
// clear_nodes    group shape: what climb_boxes exchanges with starts as NOT_REACHED and zeros
//   out    reached [leaf_count], nodes
//   launch ceil(leaf_count / WORK_GROUP_SIZE) groups
// climb_boxes    group shape: one work item a leaf; the second to reach a node goes on (Apetrei 2014)
//   in     codes, primitive_ids [leaf_count], boxes, by primitive
//   inout  reached, nodes
//   out    root_reference [1]
//   launch ceil(leaf_count / WORK_GROUP_SIZE) groups
// build_pieces   lane shape: one work item a contiguous piece of the leaves, with a stack instead of atomics
//   out    pending [groups * MOST_PENDING], pending_counts [groups]: subtrees that the piece's borders leave incomplete
// join_pieces    lane shape: one work item finishes with the pending subtrees of all pieces
// The trees are the same.
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "morton_split.clh"
#include "between_groups.clh"
#include "cluster_constants.h"

#if LANE_SHAPE

// How far ahead of its use a box is fetched.
#ifndef LEAF_BOX_AHEAD
#define LEAF_BOX_AHEAD 16
#endif
#define STREAM_AHEAD 128

// A subtree as its node in the array (node.clh), its smallest position, and the level of the border before that.
typedef struct {
    float8 node;
    uint first;
    int level;
} Subtree;
EXPECT_SIZE(Subtree, PENDING_BYTES);

static inline Subtree leaf_subtree(global const float* boxes, uint id, uint position, int level) {
    global const float* box = boxes + BOX_FLOATS * (size_t)id;
    const float4 lower = vload4(0, box);
    const float4 upper = vload4(0, box + 2);
    const Subtree leaf = {(float8)(lower.s012, as_float(position), upper.s123, as_float(1u)), position, level};
    return leaf;
}

static inline float8 merge_nodes(float8 a, float8 b, uint slot) {
    const float8 lower = MIN_OF(a, b);
    const float8 upper = MAX_OF(a, b);
    return (float8)(lower.s012, as_float(2 * slot), upper.s456, as_float(0u));
}

// Puts `subtree` on the stack of neighbouring subtrees, having merged it with those at the top as long as the border
// between the two is the deepest around. `right_level` is that of the border behind it. Returns the stack's
// new size.
static inline uint push_subtree(Subtree* stack, uint size, Subtree subtree, int right_level, global float* nodes) {
    while (size > 0 && subtree.level <= right_level && subtree.level <= stack[size - 1].level) {
        const Subtree left = stack[size - 1];
        STREAM_STORE16((float16)(left.node, subtree.node), subtree.first, nodes);
        subtree.node = merge_nodes(left.node, subtree.node, subtree.first);
        subtree.first = left.first;
        subtree.level = left.level;
        --size;
    }
    stack[size] = subtree;
    return size + 1;
}

KERNEL void build_pieces(global const ulong* codes, global const uint* primitive_ids, global const float* boxes,
                         global const uint* leaf_count_in, uint piece_length, global float* nodes,
                         global Subtree* pending, global uint* pending_counts) {
    const uint leaf_count = *leaf_count_in;
    const uint begin = min((uint)get_group_id(0) * piece_length, leaf_count);
    const uint end = min(begin + piece_length, leaf_count);
    Subtree stack[MOST_PENDING];
    uint size = 0;
    int level = border_level(codes, begin, leaf_count);
    for (uint i = begin; i < end; ++i) {
        PREFETCH(codes + i + STREAM_AHEAD);
        PREFETCH(primitive_ids + i + STREAM_AHEAD);
        PREFETCH(boxes + BOX_FLOATS * (size_t)primitive_ids[min(i + LEAF_BOX_AHEAD, end - 1)]);
        const int right_level = border_level(codes, i + 1, leaf_count);
        size = push_subtree(stack, size, leaf_subtree(boxes, primitive_ids[i], i, level), right_level, nodes);
        level = right_level;
    }
    for (uint k = 0; k < size; ++k) {
        pending[get_group_id(0) * MOST_PENDING + k] = stack[k];
    }
    pending_counts[get_group_id(0)] = size;
}

KERNEL void join_pieces(global const Subtree* pending, global const uint* pending_counts, uint piece_count,
                        global const uint* leaf_count_in, global float* nodes, global uint* root_reference) {
    const uint leaf_count = *leaf_count_in;
    Subtree stack[MOST_PENDING];
    uint size = 0;
    Subtree next = pending[0];
    int first_one = 1;
    for (uint piece = 0; piece < piece_count; ++piece) {
        for (uint k = 0; k < pending_counts[piece]; ++k) {
            const Subtree following = pending[piece * MOST_PENDING + k];
            if (!first_one) {
                size = push_subtree(stack, size, next, following.level, nodes);
            }
            next = following;
            first_one = 0;
        }
    }
    push_subtree(stack, size, next, OUTER_LEVEL, nodes);
    *root_reference = leaf_count == 1 ? 0 : leaf_count + as_uint(stack[0].node.s3) / 2;
}

#else

KERNEL void clear_nodes(global const uint* leaf_count_in, global uint* reached, global float* nodes) {
    const uint leaf_count = *leaf_count_in;
    const size_t slot = get_global_id(0);
    if (slot < leaf_count) {
        reached[slot] = NOT_REACHED;
        vstore16((float16)(0.0f), slot, nodes);
    }
}

static inline void publish_node(global uint* node, Box box, uint reference, uint leaf_count) {
    publish_box(node, box);
    node[3] = node_first(reference, leaf_count);
    node[7] = node_count(reference, leaf_count);
}

KERNEL void climb_boxes(global const ulong* codes, global const uint* primitive_ids, global const float* boxes,
                        global const uint* leaf_count_in, global uint* reached, global uint* nodes,
                        global uint* root_reference) {
    const uint leaf_count = *leaf_count_in;
    const size_t leaf = get_global_id(0);
    if (leaf >= leaf_count) {
        return;
    }
    Box box = load_box(boxes + BOX_FLOATS * (size_t)primitive_ids[leaf]);
    uint reference = (uint)leaf;
    uint begin = (uint)leaf;
    uint end = begin + 1;
    while (begin > 0 || end < leaf_count) {
        // The deeper of the two borders is where this node meets its sibling.
        const int is_left = border_level(codes, end, leaf_count) < border_level(codes, begin, leaf_count);
        const uint slot = is_left ? end : begin;
        publish_node(nodes + 16 * (size_t)slot + (is_left ? 0 : 8), box, reference, leaf_count);
        DEVICE_FENCE();
        const uint sibling_border = atomic_xchg(reached + slot, is_left ? begin : end);
        if (sibling_border == NOT_REACHED) {
            return;
        }
        DEVICE_FENCE();
        box = merge_boxes(box, observe_box(nodes + 16 * (size_t)slot + (is_left ? 8 : 0)));
        reference = leaf_count + slot;
        begin = is_left ? begin : sibling_border;
        end = is_left ? sibling_border : end;
    }
    *root_reference = reference;
}

#endif
