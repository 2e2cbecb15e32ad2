// A layout of WIDE_WIDTH children a node (clbvh/layout/wide.hpp), the same bytes as the host's make_layout(), from a
// binary tree. Every array is a buffer, and an offset in bytes of ScenePlace or LayoutPlace (layout_constants.h).
//
//   in     nodes [node_count] (tree_nodes.clh), primitive ids, a mesh (input.clh)
//   out    header [LAYOUT_HEADER_WORDS]; nodes, blocks (layout_constants.h); sources, for nodes of eight: for
//          each child of each node the node of the binary tree whose box it has
//   scratch  state [OPENING_WORDS], pieces [PIECE_SLOTS * PIECE_WORDS], next_chunks, records (open_piece.clh)
//
// open_top      one group: the top of the tree level by level, until enough nodes wait; each becomes a piece
// open_pieces   a group for each piece but the first: all that is below
// number_pieces one group: where the nodes and blocks of each piece begin
// write_pieces  a group for each piece
//               and for nodes of eight
// write_rows    out rows [LEAF_ROWS * reference_count], where state was; a group for `length` references
// refit_layout  any number of groups; `sources` and the blocks' primitives say what to read
//   in     the header, sources
//   inout  nodes, whose boxes become the binary nodes', blocks, whose vertices become the mesh's
// local  4 * WORK_GROUP_SIZE + 4 bytes
#include "work_group.clh"
#include "place.clh"
#include "aabb.clh"
#include "input.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "ray_constants.h"
#include "open_piece.clh"
#include "write_piece.clh"

static inline Opening opening_at(ScenePlace scene, global const uchar* tree, LayoutPlace place, global uchar* layout) {
    Opening opening;
    opening.nodes = AT(const uint, tree, scene.nodes);
    opening.state = AT(uint, layout, place.state);
    opening.pieces = AT(uint, layout, place.pieces);
    opening.next_chunks = AT(uint, layout, place.next_chunks);
    opening.records = AT(uint, layout, place.records);
    return opening;
}

static inline Target target_at(ScenePlace scene, global const uchar* primitive_ids, global const uchar* vertices,
                               global const uchar* indices, LayoutPlace place, global uchar* layout) {
    Target target;
    target.input = input_at(vertices, scene.vertices, scene.vertex_stride, indices, scene.indices, scene.index_stride);
    target.form = scene.form;
    target.primitive_ids = AT(const uint, primitive_ids, scene.primitive_ids);
    target.nodes = AT(float, layout, place.nodes);
    target.blocks = AT(float, layout, place.blocks);
    target.sources = AT(uint, layout, place.sources);
    return target;
}

static inline global uint* piece_at(Opening o, uint piece) {
    return o.pieces + PIECE_WORDS * (size_t)piece;
}

KERNEL void open_top(global const uchar* tree, global const uchar* active_count, ScenePlace scene, global uchar* layout,
                     LayoutPlace place) {
    local uint sums[WORK_GROUP_SIZE];
    local uint shared_chunk;
    const Opening o = opening_at(scene, tree, place, layout);
    const uint size = nodes_in_use(scene.node_count, active_count, scene.active_count, scene.has_active_count);
    if (LOCAL_ID == 0) {
        o.state[OPENING_CHUNKS] = 0;
        o.state[OPENING_PIECES] = 0;
        o.state[OPENING_TOP] = 0;
    }
    GLOBAL_BARRIER();
    // The same for all items.
    if (size == 0 || (link_of(o.nodes, 0).first == 0 && link_of(o.nodes, 0).count == 0)) return;
    const Link root = link_of(o.nodes, 0);
    const int is_large_leaf = root.count > BLOCK_TRIANGLES * WIDE_MOST_BLOCKS;
    const uint wanted = min(size / NODES_OF_PIECE, (uint)MOST_PIECES);
    const uint4 item = (uint4)(0, 1, is_large_leaf ? root.first : 0, is_large_leaf ? root.count : 0);
    global uint* const top = piece_at(o, 0);
    Queue queue = begin_queue(o, top, item, &shared_chunk);
    while (queue.begin < queue.end && queue.end - queue.begin < wanted)
        queue = open_some(o, queue, 1, top, sums, &shared_chunk);
    end_queue(queue, top);
    if (LOCAL_ID == 0) {
        o.state[OPENING_PIECES] = 1 + queue.end - queue.begin;
        o.state[OPENING_TOP] = queue.end;
    }
    // Nobody else takes chunks yet: these are one behind the other.
    FOR_WORK_ITEMS(i, queue.begin, queue.end) {
        const uint4 root_item = vload4(0, record_at(o, (uint)i / RECORDS_OF_CHUNK, (uint)i));
        vstore4(root_item, 0, piece_at(o, 1 + (uint)i - queue.begin) + PIECE_ROOT);
    }
}

KERNEL void open_pieces(global const uchar* tree, ScenePlace scene, global uchar* layout, LayoutPlace place) {
    local uint sums[WORK_GROUP_SIZE];
    local uint shared_chunk;
    const Opening o = opening_at(scene, tree, place, layout);
    const uint number = 1 + (uint)get_group_id(0);
    if (number >= o.state[OPENING_PIECES]) return;
    global uint* const piece = piece_at(o, number);
    Queue queue = begin_queue(o, piece, vload4(0, piece + PIECE_ROOT), &shared_chunk);
    while (queue.begin < queue.end)
        queue = open_some(o, queue, RECORDS_OF_CHUNK, piece, sums, &shared_chunk);
    end_queue(queue, piece);
}

KERNEL void number_pieces(global const uchar* tree, ScenePlace scene, global uchar* layout, LayoutPlace place) {
    local uint sums[WORK_GROUP_SIZE];
    local uint depth;
    const Opening o = opening_at(scene, tree, place, layout);
    global uint* const header = AT(uint, layout, place.header);
    const uint pieces = o.state[OPENING_PIECES];
    uint nodes = o.state[OPENING_TOP], blocks = 0;
    if (LOCAL_ID == 0) depth = 0;
    LOCAL_BARRIER();
    for (uint begin = 0; begin < pieces; begin += WORK_GROUP_SIZE) {
        const uint number = begin + LOCAL_ID;
        const int is_there = number < pieces;
        global uint* const piece = piece_at(o, number);
        // The roots of all others are in the top.
        const uint own_nodes = is_there && number > 0 ? piece[PIECE_NODES] - 1 : 0;
        const uint own_blocks = is_there ? piece[PIECE_BLOCKS] : 0;
        uint all_nodes, all_blocks;
        const uint nodes_before = nodes + group_exclusive_scan(sums, own_nodes, &all_nodes);
        const uint blocks_before = blocks + group_exclusive_scan(sums, own_blocks, &all_blocks);
        if (is_there) {
            piece[PIECE_FIRST_NODE] = number == 0 ? 0 : nodes_before;
            piece[PIECE_FIRST_BLOCK] = blocks_before;
            // The top has opened nothing where the root is a piece.
            if (piece[PIECE_NODES] > 0) atomic_max(&depth, piece[PIECE_DEPTH]);
        }
        nodes += all_nodes;
        blocks += all_blocks;
    }
    LOCAL_BARRIER();
    // Numbers of blocks have so many bits.
    const int fits = blocks < 1u << WIDE_BLOCK_COUNT_SHIFT;
    if (LOCAL_ID == 0) {
        header[LAYOUT_NODE_COUNT] = fits ? nodes : 0;
        header[LAYOUT_BLOCK_COUNT] = fits ? blocks : 0;
        header[LAYOUT_DEPTH] = fits ? depth : 0;
    }
}

KERNEL void write_pieces(global const uchar* tree, global const uchar* primitive_ids, global const uchar* vertices,
                         global const uchar* indices, ScenePlace scene, global uchar* layout, LayoutPlace place) {
    const Opening o = opening_at(scene, tree, place, layout);
    const Target target = target_at(scene, primitive_ids, vertices, indices, place, layout);
    const uint number = (uint)get_group_id(0);
    global const float* const binary_nodes = (global const float*)o.nodes;
    if (number >= o.state[OPENING_PIECES] || AT(uint, layout, place.header)[LAYOUT_NODE_COUNT] == 0) return;
    global const uint* const piece = piece_at(o, number);
    // A piece's root has its place in the top, where it waited behind those that are opened there.
    const uint root = piece_at(o, 0)[PIECE_NODES] + number - 1;
    const uint first_block = piece[PIECE_FIRST_BLOCK];
    const uint first_node = number == 0 ? 0 : piece[PIECE_FIRST_NODE] - 1;  // of its record 0
    const uint records_of_piece = piece[PIECE_NODES];
    uint chunk = piece[PIECE_CHUNK];
    for (uint begin = 0; begin < records_of_piece; begin += RECORDS_OF_CHUNK) {
        if (begin > 0) chunk = o.next_chunks[chunk];
        const uint count = min(records_of_piece - begin, (uint)RECORDS_OF_CHUNK);
        // Of the chunk's first record, and that less their places in the chunk of the others.
        const size_t next = first_node + begin, first = number > 0 && begin == 0 ? root : next;
        write_records(target, binary_nodes, record_at(o, chunk, 0), count, first, next, first_node, first_block);
    }
}

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
