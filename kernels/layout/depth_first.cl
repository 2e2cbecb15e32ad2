// Layouts whose nodes are in depth-first order (clbvh/layout/skip.hpp, pair.hpp), the same bytes as the host's
// make_layout(), from a binary tree. Every array is a buffer, and an offset in bytes of ScenePlace or DepthFirstPlace
// (layout_constants.h). A pair is named by half the slot of its left node; what is kept of a pair is its parent's.
//
//   in     nodes [node_count] (tree_nodes.clh), primitive ids
//   out    header [LAYOUT_HEADER_WORDS]; nodes, SKIP_NODE_WORDS or PAIR_NODE_WORDS each; primitive_ids
//   scratch  parents [pairs]: slots; below [pairs * SUBTREE_WORDS]; places, next_places [pairs * PLACE_WORDS];
//            top [pairs]: pairs whose parents have more than SUBTREE_NODES nodes below them, in any order
//
// link_pairs   a group for SLOTS_PER_GROUP slots: parents, and nobody has been anywhere
// measure      any number of groups, which take SLOTS_PER_GROUP slots in turn; one, where groups hand nothing over
// within
//              a launch: how much is below each inner node, upwards; the second to reach a node goes on. Lists the top
// place_top    any number of groups, as all that follow: where the top's nodes are, counted from their parents' places
// double_ways  the same, counted from the place of the node that the parent's was counted from: after so many launches
//              as the depth has bits, from the beginning (Wyllie 1979, "The Complexity of Parallel Computations")
// write_nodes  the top's nodes, and subtrees below it, each by one work item
#include "work_group.clh"
#include "place.clh"
#include "aabb.clh"
#include "between_groups.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "layout_constants.h"

// Most nodes of a subtree that one work item writes.
#ifndef SUBTREE_NODES
#if LANE_SHAPE
#define SUBTREE_NODES 512
#else
#define SUBTREE_NODES 32
#endif
#endif

#define NO_PAIR 0xFFFFFFFFu

typedef struct {
    global const Node* nodes;
    global uint* header;
    global uint* parents;
    global uint* below;
    global uint* arrivals;  // where next_places will be
    global uint* top;
} Order;

static inline Order order_at(ScenePlace scene, global const uchar* tree, DepthFirstPlace place, global uchar* layout) {
    Order order;
    order.nodes = AT(const Node, tree, scene.nodes);
    order.header = AT(uint, layout, place.header);
    order.parents = AT(uint, layout, place.parents);
    order.below = AT(uint, layout, place.below);
    order.arrivals = AT(uint, layout, place.next_places);
    order.top = AT(uint, layout, place.top);
    return order;
}

// A node and all that is below it.
typedef struct {
    uint nodes, ids, height;
} Subtree;

static inline Subtree subtree_of(Order o, uint slot) {
    const uint first = o.nodes[slot].first, count = o.nodes[slot].count;
    Subtree subtree = {1, count, 0};
    if (count == 0) {
        global const uint* const words = o.below + SUBTREE_WORDS * (size_t)(first / 2);
        subtree.nodes = words[0];
        subtree.ids = words[1];
        subtree.height = words[2];
    }
    return subtree;
}

static inline Subtree join_subtrees(Subtree left, Subtree right) {
    const Subtree all = {1 + left.nodes + right.nodes, left.ids + right.ids, 1 + max(left.height, right.height)};
    return all;
}

KERNEL void link_pairs(global const uchar* tree, global const uchar* active_count, ScenePlace scene,
                       global uchar* layout, DepthFirstPlace place) {
    const Order o = order_at(scene, tree, place, layout);
    const size_t size = nodes_in_use(scene.node_count, active_count, scene.active_count, scene.has_active_count);
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP, end = min(begin + SLOTS_PER_GROUP, size);
    if (get_group_id(0) == 0) {
        FOR_WORK_ITEMS(word, 0, LAYOUT_HEADER_WORDS) {
            o.header[word] = 0;
        }
    }
    FOR_WORK_ITEMS(slot, begin, end) {
        const uint first = o.nodes[slot].first;
        if (!is_inner(first, o.nodes[slot].count)) continue;
        o.parents[first / 2] = (uint)slot;
        o.arrivals[first / 2] = 0;
    }
}

static inline void publish_subtree(Order o, uint pair, Subtree subtree) {
    global uint* const words = o.below + SUBTREE_WORDS * (size_t)pair;
    publish_word(words + 0, subtree.nodes);
    publish_word(words + 1, subtree.ids);
    publish_word(words + 2, subtree.height);
}

static inline Subtree observe_subtree(Order o, uint pair) {
    global uint* const words = o.below + SUBTREE_WORDS * (size_t)pair;
    const Subtree subtree = {observe_word(words + 0), observe_word(words + 1), observe_word(words + 2)};
    return subtree;
}

static inline void write_header(Order o, Subtree all) {
    o.header[LAYOUT_NODE_COUNT] = all.nodes;
    o.header[LAYOUT_BLOCK_COUNT] = all.ids;
    o.header[LAYOUT_DEPTH] = all.height;
}

// `pair` is one of two leaves.
static inline void measure_upwards(Order o, uint pair) {
    Subtree all = join_subtrees(subtree_of(o, 2 * pair), subtree_of(o, 2 * pair + 1));
    for (;;) {
        publish_subtree(o, pair, all);
        if (all.nodes > SUBTREE_NODES) o.top[atomic_inc(o.header + LAYOUT_TOP)] = pair;
        const uint slot = o.parents[pair];
        if (slot == ROOT_SLOT) {
            write_header(o, all);
            return;
        }
        pair = slot / 2;
        const uint sibling = SIBLING_OF(slot);
        Subtree other = {1, o.nodes[sibling].count, 0};
        if (other.ids == 0) {
            DEVICE_FENCE();
            if (atomic_xchg(o.arrivals + pair, 1u) == 0) return;
            DEVICE_FENCE();
            other = observe_subtree(o, o.nodes[sibling].first / 2);
        }
        all = join_subtrees(all, other);
    }
}

KERNEL void measure(global const uchar* tree, global const uchar* active_count, ScenePlace scene, global uchar* layout,
                    DepthFirstPlace place) {
    const Order o = order_at(scene, tree, place, layout);
    const size_t size = nodes_in_use(scene.node_count, active_count, scene.active_count, scene.has_active_count);
    const size_t pairs = (size + 1) / 2;
    const size_t step = SLOTS_PER_GROUP / 2;
    for (size_t begin = get_group_id(0) * step; begin < pairs; begin += get_num_groups(0) * step) {
        FOR_WORK_ITEMS(pair, begin, min(begin + step, pairs)) {
            if (pair == 0) {
                if (o.nodes[ROOT_SLOT].count > 0) write_header(o, subtree_of(o, ROOT_SLOT));
            } else if (o.nodes[2 * pair].count > 0 && o.nodes[2 * pair + 1].count > 0) {
                measure_upwards(o, (uint)pair);
            }
        }
    }
}

// The nodes and primitive ids between two places, and the pair whose parent has the first of them.
typedef struct {
    uint from, nodes, ids;
} Way;

static inline Way way_at(global const uchar* layout, ulong places, uint pair) {
    global const uint* const words = AT(const uint, layout, places) + PLACE_WORDS * (size_t)pair;
    const Way way = {words[0], words[1], words[2]};
    return way;
}

static inline void write_way(global uchar* layout, ulong places, uint pair, Way way) {
    global uint* const words = AT(uint, layout, places) + PLACE_WORDS * (size_t)pair;
    words[0] = way.from;
    words[1] = way.nodes;
    words[2] = way.ids;
}

// From a node to its child in `slot`.
static inline Way way_to_child(Order o, uint slot) {
    Way way = {slot / 2, 1, 0};
    if (slot % 2 == 1) {
        const Subtree left = subtree_of(o, slot - 1);
        way.nodes += left.nodes;
        way.ids = left.ids;
    }
    return way;
}

// Which part of the top is this group's.
#define TOP_SHARE(o) (((o).header[LAYOUT_TOP] + get_num_groups(0) - 1) / get_num_groups(0))
#define FOR_TOP(i, o)                                         \
    FOR_WORK_ITEMS(i, get_group_id(0) * (size_t)TOP_SHARE(o), \
                   min((get_group_id(0) + 1) * (size_t)TOP_SHARE(o), (size_t)(o).header[LAYOUT_TOP]))

KERNEL void place_top(global const uchar* tree, ScenePlace scene, global uchar* layout, DepthFirstPlace place) {
    const Order o = order_at(scene, tree, place, layout);
    FOR_TOP(i, o) {
        const uint pair = o.top[i], slot = o.parents[pair];
        const Way none = {NO_PAIR, 0, 0};
        write_way(layout, place.places, pair, slot == ROOT_SLOT ? none : way_to_child(o, slot));
    }
}

// Launches of double_ways until all ways begin at the root. No node of the top is deeper than the tree less one.
static inline uint doublings_of(uint depth) {
    return depth > 1 ? 32 - clz(depth - 1) : 0;
}

KERNEL void double_ways(global const uchar* tree, ScenePlace scene, global uchar* layout, DepthFirstPlace place,
                        uint doubling) {
    const Order o = order_at(scene, tree, place, layout);
    if (doubling >= doublings_of(o.header[LAYOUT_DEPTH])) return;
    const ulong from = doubling % 2 == 0 ? place.places : place.next_places;
    const ulong to = doubling % 2 == 0 ? place.next_places : place.places;
    FOR_TOP(i, o) {
        const uint pair = o.top[i];
        Way way = way_at(layout, from, pair);
        if (way.from != NO_PAIR) {
            const Way before = way_at(layout, from, way.from);
            way.from = before.from;
            way.nodes += before.nodes;
            way.ids += before.ids;
        }
        write_way(layout, to, pair, way);
    }
}

typedef struct {
    Order order;
    global const uint* read_ids;
    global uint* nodes;
    global uint* ids;
    uint is_pair;
} Output;

static inline global uint* node_at(Output t, uint number) {
    return t.nodes + (t.is_pair ? PAIR_NODE_WORDS : SKIP_NODE_WORDS) * (size_t)number;
}

// The node `number`, whose right child is node `right`, and behind all of which comes node `end`.
static inline void write_inner(Output t, uint slot, uint number, uint right, uint end) {
    global const uint* const binary_nodes = (global const uint*)t.order.nodes;
    global uint* const node = node_at(t, number);
    if (t.is_pair) {
        const uint first = t.order.nodes[slot].first;
        const uint8 l = vload8(first, binary_nodes), r = vload8((size_t)first + 1, binary_nodes);
        vstore8((uint8)(l.s012, number + 1, l.s456, right), 0, node);
        vstore8((uint8)(r.s012, 0, r.s456, 0), 1, node);
    } else {
        const uint8 n = vload8(slot, binary_nodes);
        vstore8((uint8)(n.s012, end, n.s456, 0), 0, node);
    }
}

static inline void write_leaf(Output t, uint slot, uint number, uint id) {
    global uint* const node = node_at(t, number);
    const uint8 n = vload8(slot, (global const uint*)t.order.nodes);
    if (t.is_pair) {
        vstore8((uint8)(0), 0, node);
        vstore8((uint8)(0, 0, 0, n.s7, 0, 0, 0, id), 1, node);
    } else {
        vstore8((uint8)(n.s012, id, n.s456, n.s7), 0, node);
    }
    for (uint i = 0; i < n.s7; ++i)
        t.ids[(size_t)id + i] = t.read_ids[(size_t)n.s3 + i];
}

// Where the slot of a node waits that is to be written.
#define WAITING 3

static inline void write_subtree(Output t, uint slot, uint number, uint id) {
    const uint end = number + subtree_of(t.order, slot).nodes;
    node_at(t, number)[WAITING] = slot;
    for (; number < end; ++number) {
        slot = node_at(t, number)[WAITING];
        const uint first = t.order.nodes[slot].first, count = t.order.nodes[slot].count;
        if (count > 0) {
            write_leaf(t, slot, number, id);
            id += count;
            continue;
        }
        const uint right = number + 1 + subtree_of(t.order, first).nodes;
        node_at(t, number + 1)[WAITING] = first;
        node_at(t, right)[WAITING] = first + 1;
        write_inner(t, slot, number, right, number + subtree_of(t.order, slot).nodes);
    }
}

KERNEL void write_nodes(global const uchar* tree, global const uchar* primitive_ids, ScenePlace scene,
                        global uchar* layout, DepthFirstPlace place, uint is_pair) {
    Output t;
    t.order = order_at(scene, tree, place, layout);
    t.read_ids = AT(const uint, primitive_ids, scene.primitive_ids);
    t.nodes = AT(uint, layout, place.nodes);
    t.ids = AT(uint, layout, place.primitive_ids);
    t.is_pair = is_pair;
    global const uint* const header = t.order.header;
    const int is_one_subtree = header[LAYOUT_NODE_COUNT] > 0 && header[LAYOUT_TOP] == 0;
    if (is_one_subtree && get_global_id(0) == 0) write_subtree(t, ROOT_SLOT, 0, 0);
    const ulong places = doublings_of(header[LAYOUT_DEPTH]) % 2 == 0 ? place.places : place.next_places;
    FOR_TOP(i, t.order) {
        const uint pair = t.order.top[i], slot = t.order.parents[pair];
        const Way way = way_at(layout, places, pair);
        const uint right = way.nodes + way_to_child(t.order, 2 * pair + 1).nodes;
        write_inner(t, slot, way.nodes, right, way.nodes + subtree_of(t.order, slot).nodes);
        for (uint child = 2 * pair; child < 2 * pair + 2; ++child) {
            if (subtree_of(t.order, child).nodes > SUBTREE_NODES) continue;
            const Way to_child = way_to_child(t.order, child);
            write_subtree(t, child, way.nodes + to_child.nodes, way.ids + to_child.ids);
        }
    }
}
