// Many small trees in one launch: every work group builds one of them alone, from the boxes to the root, by the rules
// of PLOC++ (plocpp.cl), in parts of arrays that all groups share.
//
// batch_indexed_32, and one of the same for every other form of input
//   in    input (input.clh); ranges [groups * 4]: first primitive of the tree, primitives, what is added to their
//         vertex indices, unused
//   out   of the tree whose first primitive is f: nodes [2 * n] from 2 * f on, primitive_ids [n] from f on, both
//         counted from f; active_counts [groups]
//         scratch: leaves [(6 * n + 2) a tree], inner [8 * n], references, other [n], bounds [12 * groups]
//   launch one group a tree
//
// local  as plocpp.cl, and 17 * WORK_GROUP_SIZE * 4 bytes; lane shape: none
#include "work_group.clh"
#include "lanes.clh"
#include "aabb.clh"
#include "node.clh"
#include "scan.clh"
#include "input.clh"
#include "scene_bounds.clh"
#include "morton.clh"
#include "morton_grid.clh"
#include "packed_key.clh"
#include "small_sort.clh"
#include "cluster.clh"
#define BORDER (2 * SEARCH_RADIUS)
#include "chunk.clh"
#include "neighbour_search.clh"
#include "merge.clh"
#include "range.clh"
#include "root.clh"

#define RANGE_WORDS 4

// The code bits that sort a tree of `count` primitives where there may be `most`: as BuildSettings::key_layout has it.
#ifndef MOST_CODE_BITS
#define MOST_CODE_BITS 44
#endif
#ifndef CUBIC_CELLS
#define CUBIC_CELLS 1
#endif

static inline uint index_bits_of(uint count) {
    return 32 - clz(count - 1);
}

// The input from primitive `first` on, with vertices from `first_vertex` on.
static inline Input input_from(Input input, uint form, size_t first, size_t first_vertex) {
    if (form == INPUT_BOXES) {
        first_vertex = first;
    } else if (form == INPUT_TRIANGLES) {
        first_vertex = 3 * first;
    }
    input.vertices += first_vertex * input.vertex_stride;
    input.indices += first * input.index_stride;
    return input;
}

static inline void make_keys(global const float* boxes, global const float* bounds, uint count, uint index_bits,
                             uint code_bits, global ulong* keys) {
    MortonGrid grid;
    make_grid(LOWER_CENTROID(bounds), UPPER_CENTROID(bounds), CUBIC_CELLS, &grid);
    FOR_WORK_ITEMS(i, 0, count) {
        keys[i] = pack_key(code_of_record(grid, boxes + BOX_FLOATS * i), i, index_bits, code_bits);
    }
}

static inline void place_leaves(global const float* boxes, global const ulong* keys, uint index_bits, uint leaf_count,
                                global uint* primitive_ids, global float* leaves, global uint* references) {
    const ulong index_mask = (1ul << index_bits) - 1;
    FOR_WORK_ITEMS(i, 0, leaf_count) {
        const uint primitive = (uint)(keys[i] & index_mask);
        primitive_ids[i] = primitive;
        references[i] = (uint)i;
        store_box(leaves + BOX_FLOATS * i, load_box(boxes + BOX_FLOATS * (size_t)primitive));
    }
    FOR_WORK_ITEMS(k, 0, 2) {
        leaves[BOX_FLOATS * (size_t)leaf_count + k] = 0.0f;
    }
}

// A tree's parts of the arrays. Boxes and keys are done with when nodes and inner clusters take their place.
typedef struct {
    global float* nodes;
    global uint* primitive_ids;
    global float* leaves;
    global float* inner;
    global uint* references;
    global uint* other;
    global float* bounds;
} BatchPart;

static inline uint leaves_of_tree(Input input, uint form, uint count, BatchPart part, local SceneBounds* scratch,
                                  local uint* scan) {
    global float* const boxes = part.nodes;
    SceneBounds mine;
    const uint active = bounds_of_piece(input, form, 0, count, boxes, &mine);
    store_bounds(part.bounds, reduce_over_group(scratch, mine));
    uint leaf_count;
    group_exclusive_scan(scan, active, &leaf_count);
    GLOBAL_BARRIER();
    const uint index_bits = index_bits_of(count);
    const uint code_bits = min((uint)MOST_CODE_BITS, 64 - index_bits);
    global ulong* const keys = (global ulong*)part.inner;
    make_keys(boxes, part.bounds, count, index_bits, code_bits, keys);
    GLOBAL_BARRIER();
    global const ulong* const sorted = sort_keys(keys, keys + count, count, index_bits, code_bits);
    place_leaves(boxes, sorted, index_bits, leaf_count, part.primitive_ids, part.leaves, part.references);
    GLOBAL_BARRIER();
    return leaf_count;
}

#define DEFINE_BATCH(name, form)                                                                                       \
    KERNEL void name(global const uchar* vertices, ulong vertex_offset, uint vertex_stride,                            \
                     global const uchar* indices, ulong index_offset, uint index_stride,                               \
                     global const uchar* range_memory, ulong range_offset, global float* nodes,                        \
                     global uint* primitive_ids, global uint* active_counts, global float* leaves,                     \
                     global float* inner, global uint* references, global uint* other, global float* bounds) {         \
        DECLARE_CHUNK(chunk);                                                                                          \
        DECLARE_SEARCH_SCRATCH(search);                                                                                \
        DECLARE_MERGE(survivor, merging, chunk);                                                                       \
        local SceneBounds scratch[WORK_GROUP_SIZE];                                                                    \
        local uint scan[WORK_GROUP_SIZE];                                                                              \
        const size_t tree = get_group_id(0);                                                                           \
        global const uint* const range = (global const uint*)(range_memory + range_offset) + RANGE_WORDS * tree;       \
        const size_t first = range[0];                                                                                 \
        const uint count = range[1];                                                                                   \
        const Input all = input_at(vertices, vertex_offset, vertex_stride, indices, index_offset, index_stride);       \
        const Input input = input_from(all, form, first, range[2]);                                                    \
        const BatchPart part = {nodes + 16 * first,                                                                    \
                                primitive_ids + first,                                                                 \
                                leaves + BOX_FLOATS * first + 2 * tree,                                                \
                                inner + RECORD_FLOATS * first,                                                         \
                                references + first,                                                                    \
                                other + first,                                                                         \
                                bounds + BOUNDS_FLOATS * tree};                                                        \
        const uint leaf_count = leaves_of_tree(input, form, count, part, scratch, scan);                               \
        cluster_range(chunk, search, survivor, merging, scan, part.references, part.other, leaf_count, 1, part.leaves, \
                      part.inner, part.nodes, leaf_count);                                                             \
        if (LOCAL_ID == 0) {                                                                                           \
            active_counts[tree] = leaf_count;                                                                          \
            if (count > 0) {                                                                                           \
                const Box only_box = leaf_count == 1 ? load_box(part.leaves) : empty_box();                            \
                write_root_pair((global Node*)part.nodes, part.references[0], leaf_count, leaf_count, only_box);       \
            }                                                                                                          \
        }                                                                                                              \
    }

DEFINE_BATCH(batch_indexed_32, INPUT_INDEXED_32)
DEFINE_BATCH(batch_indexed_16, INPUT_INDEXED_16)
DEFINE_BATCH(batch_triangles, INPUT_TRIANGLES)
DEFINE_BATCH(batch_boxes, INPUT_BOXES)
