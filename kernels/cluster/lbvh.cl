// LBVH: the binary tree that sorted Morton codes imply, with boxes, in one bottom-up pass. Every border between
// neighbouring positions is one inner node, numbered by the position behind it (node.clh).
//
// clear_nodes    group shape: what climb_boxes exchanges with starts as NOT_REACHED, or zeros
//   out    reached [leaf_count], nodes
//   launch ceil(leaf_count / WORK_GROUP_SIZE) groups
// climb_boxes    group shape: one work item a leaf; the second to reach a node goes on (Apetrei 2014)
//   in     codes, primitive_ids [leaf_count], boxes, by primitive
//   inout  reached, nodes
//   out    root_reference [1]
//   launch ceil(leaf_count / WORK_GROUP_SIZE) groups
// begin_climbs, climb_once   group shape, where groups hand nothing over within a launch
//                each launch of climb_once is a step of climb_boxes
//   inout  climbs [leaf_count]
//   launch as climb_boxes; climb_once MOST_STEPS times, or leaf_count where that is less
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

static inline void publish_node(global uint* node, Box box, uint reference, uint leaf_count) {
    publish_box(node, box);
    node[3] = node_first(reference, leaf_count);
    node[7] = node_count(reference, leaf_count);
}

// Where a work item stands: at a node over [begin, end), whose right child begins at `split`; at its leaf where that is
// 0. Nowhere, the rest being the other's, where the range is empty.
typedef struct {
    uint begin, split, end;
} Climb;
EXPECT_SIZE(Climb, CLIMB_BYTES);

typedef struct {
    global const ulong* codes;
    uint leaf_count;
    global uint* reached;
    global uint* nodes;
} Boxes;

static inline uint reference_of(Boxes b, Climb climb) {
    return climb.split == 0 ? climb.begin : b.leaf_count + climb.split;
}

static inline int is_root(Boxes b, Climb climb) {
    return climb.begin == 0 && climb.end == b.leaf_count;
}

// Where a node meets its sibling: the slot that the two are the children of, and its own side.
typedef struct {
    uint slot;
    int is_left;
} Meeting;

// Of a node that is not the root. The deeper of its two borders is where it meets its sibling.
static inline void find_meeting(Boxes b, Climb climb, private Meeting* meeting) {
    meeting->is_left =
        border_level(b.codes, climb.end, b.leaf_count) < border_level(b.codes, climb.begin, b.leaf_count);
    meeting->slot = meeting->is_left ? climb.end : climb.begin;
}

static inline global uint* child_at(Boxes b, Meeting meeting, int is_left) {
    return b.nodes + 16 * (size_t)meeting.slot + (is_left ? 0 : 8);
}

// Publishes the node. Returns the sibling's other border, or NOT_REACHED where that is not there yet. (Where it is not
// inlined, Oclgrind's compiler keeps the box in memory, with marks that Oclgrind does not know.)
__attribute__((always_inline)) static inline uint announce_node(Boxes b, Climb climb, Meeting meeting, Box box) {
    publish_node(child_at(b, meeting, meeting.is_left), box, reference_of(b, climb), b.leaf_count);
    DEVICE_FENCE();
    return atomic_xchg(b.reached + meeting.slot, meeting.is_left ? climb.begin : climb.end);
}

static inline void go_to_parent(private Climb* climb, Meeting meeting, uint sibling_border) {
    if (meeting.is_left) {
        climb->end = sibling_border;
    } else {
        climb->begin = sibling_border;
    }
    climb->split = meeting.slot;
}

KERNEL void clear_nodes(global const uint* leaf_count_in, global uint* reached, global float* nodes) {
    const uint leaf_count = *leaf_count_in;
    const size_t slot = get_global_id(0);
    if (slot < leaf_count) {
        reached[slot] = NOT_REACHED;
#if PUBLISHES_BY_EXCHANGE
        vstore16((float16)(0.0f), slot, nodes);
#endif
    }
}

KERNEL void climb_boxes(global const ulong* codes, global const uint* primitive_ids, global const float* boxes,
                        global const uint* leaf_count_in, global uint* reached, global uint* nodes,
                        global uint* root_reference) {
    const Boxes b = {codes, *leaf_count_in, reached, nodes};
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= b.leaf_count) {
        return;
    }
    Climb climb = {leaf, 0, leaf + 1};
    Box box = load_box(boxes + BOX_FLOATS * (size_t)primitive_ids[leaf]);
    while (!is_root(b, climb)) {
        Meeting meeting;
        find_meeting(b, climb, &meeting);
        const uint sibling_border = announce_node(b, climb, meeting, box);
        if (sibling_border == NOT_REACHED) return;
        DEVICE_FENCE();
        box = merge_boxes(box, observe_box(child_at(b, meeting, !meeting.is_left)));
        go_to_parent(&climb, meeting, sibling_border);
    }
    *root_reference = reference_of(b, climb);
}

KERNEL void begin_climbs(global const uint* leaf_count_in, global Climb* climbs, global uint* root_reference) {
    const uint leaf = (uint)get_global_id(0);
    if (leaf == 0) *root_reference = 0;
    if (leaf >= *leaf_count_in) return;
    const Climb climb = {leaf, 0, leaf + 1};
    climbs[leaf] = climb;
}

KERNEL void climb_once(global const ulong* codes, global const uint* primitive_ids, global const float* boxes,
                       global const uint* leaf_count_in, global uint* reached, global uint* nodes,
                       global uint* root_reference, global Climb* climbs) {
    const Boxes b = {codes, *leaf_count_in, reached, nodes};
    const uint leaf = (uint)get_global_id(0);
    if (leaf >= b.leaf_count) return;
    Climb climb = climbs[leaf];
    if (climb.begin == climb.end || is_root(b, climb)) return;
    Box box;
    if (climb.split == 0) {
        box = load_box(boxes + BOX_FLOATS * (size_t)primitive_ids[leaf]);
    } else {
        global uint* const children = nodes + 16 * (size_t)climb.split;
        box = merge_boxes(observe_box(children), observe_box(children + 8));
    }
    Meeting meeting;
    find_meeting(b, climb, &meeting);
    const uint sibling_border = announce_node(b, climb, meeting, box);
    if (sibling_border == NOT_REACHED) {
        climb.begin = climb.end = 0;
    } else {
        go_to_parent(&climb, meeting, sibling_border);
    }
    climbs[leaf] = climb;
    if (is_root(b, climb)) *root_reference = reference_of(b, climb);
}

#endif
