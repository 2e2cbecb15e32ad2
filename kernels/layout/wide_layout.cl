// A layout of WIDE_WIDTH children a node (clbvh/layout/wide.hpp), the same bytes as the host's make_layout(), from a
// binary tree: pieces.clh says how. Every array is a buffer, and an offset in bytes of ScenePlace or LayoutPlace
// (layout_constants.h).
//
//   out    header [LAYOUT_HEADER_WORDS]; nodes, blocks (layout_constants.h); sources, for nodes of eight: for each
//   child
//          of each node the node of the binary tree whose box it has
//
// For nodes of eight, through which rays go, also
// write_rows    out rows [LEAF_ROWS * reference_count], where state was; a group for `length` references
// refit_layout  any number of groups; `sources` and the blocks' primitives say what to read
//   in     the header, sources
//   inout  nodes, whose boxes become the binary nodes', blocks, whose vertices become the mesh's
#include "work_group.clh"
#include "place.clh"
#include "aabb.clh"
#include "input.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "ray_constants.h"
#include "open_piece.clh"
#include "write_piece.clh"
#include "pieces.clh"

#if WIDE_WIDTH == 8
#if LANE_SHAPE
// Asks for what the rows behind row `i` will read.
static inline void fetch_row(Target t, uint primitive_count, size_t i, size_t end) {
    const uint next = t.primitive_ids[min(i + CORNER_AHEAD, end - 1)];
    const uint later = t.primitive_ids[min(i + INDEX_AHEAD, end - 1)];
    if (later < primitive_count) fetch_primitive(t, later, FETCH_INDICES);
    if (next < primitive_count) fetch_primitive(t, next, FETCH_VERTICES);
}
#endif

KERNEL void write_rows(global const uchar* primitive_ids, global const uchar* vertices, global const uchar* indices,
                       ScenePlace scene, global uchar* layout, LayoutPlace place, uint primitive_count,
                       uint reference_count, uint length) {
    const Target t = target_at(scene, primitive_ids, vertices, indices, place, layout);
    global float4* const rows = AT(float4, layout, place.rows);
    const size_t begin = (size_t)length * get_group_id(0), end = min(begin + length, (size_t)reference_count);
    FOR_WORK_ITEMS(i, begin, end) {
        const uint primitive = t.primitive_ids[i];
#if LANE_SHAPE
        fetch_row(t, primitive_count, i, end);
#endif
        // Anything may follow the tree's own references, whose number is not known.
        if (primitive >= primitive_count) continue;
        global const float* const a = corner_of(t.input, t.form, primitive, 0);
        global const float* const b = corner_of(t.input, t.form, primitive, 1);
        global const float* const c = corner_of(t.input, t.form, primitive, 2);
        rows[LEAF_ROWS * i] = (float4)(a[0], b[0], c[0], 0.0f);
        rows[LEAF_ROWS * i + 1] = (float4)(a[1], b[1], c[1], 0.0f);
        rows[LEAF_ROWS * i + 2] = (float4)(a[2], b[2], c[2], as_float(primitive + LEAF_NUMBER_BIT));
    }
}

static inline void refit_block(Target t, global float* block, uint lane) {
    const uint primitive = ((global const uint*)block)[BLOCK_PRIMITIVES + lane];
    if (primitive != NO_PRIMITIVE) write_corners(t, block, lane, primitive);
}

KERNEL void refit_layout(global const uchar* tree, global const uchar* primitive_ids, global const uchar* vertices,
                         global const uchar* indices, ScenePlace scene, global uchar* layout, LayoutPlace place) {
    const Target t = target_at(scene, primitive_ids, vertices, indices, place, layout);
    global const uint* const header = AT(uint, layout, place.header);
    const size_t groups = get_num_groups(0), group = get_group_id(0);
    const size_t children = WIDE_WIDTH * (size_t)header[LAYOUT_NODE_COUNT];
    const size_t lanes = BLOCK_TRIANGLES * (size_t)header[LAYOUT_BLOCK_COUNT];
    const size_t child_share = (children + groups - 1) / groups, lane_share = (lanes + groups - 1) / groups;
    FOR_WORK_ITEMS(i, group * child_share, min((group + 1) * child_share, children)) {
#if LANE_SHAPE
        const uint ahead = t.sources[min(i + 32, children - 1)];
        if (ahead != NO_CHILD) PREFETCH(AT(const float, tree, scene.nodes) + 8 * (size_t)ahead);
#endif
        write_box(AT(const float, tree, scene.nodes), t.sources[i], t.nodes + WIDE_NODE_FLOATS * (i / WIDE_WIDTH),
                  i % WIDE_WIDTH);
    }
    FOR_WORK_ITEMS(i, group * lane_share, min((group + 1) * lane_share, lanes)) {
#if LANE_SHAPE
        const size_t ahead = min(i + CORNER_AHEAD, lanes - 1), far = min(i + INDEX_AHEAD, lanes - 1);
        const uint next =
            ((global const uint*)
                 t.blocks)[BLOCK_FLOATS * (ahead / BLOCK_TRIANGLES) + BLOCK_PRIMITIVES + ahead % BLOCK_TRIANGLES];
        const uint later =
            ((global const uint*)
                 t.blocks)[BLOCK_FLOATS * (far / BLOCK_TRIANGLES) + BLOCK_PRIMITIVES + far % BLOCK_TRIANGLES];
        if (later != NO_PRIMITIVE) fetch_primitive(t, later, FETCH_INDICES);
        if (next != NO_PRIMITIVE) fetch_primitive(t, next, FETCH_VERTICES);
#endif
        refit_block(t, t.blocks + BLOCK_FLOATS * (i / BLOCK_TRIANGLES), i % BLOCK_TRIANGLES);
    }
}
#endif
