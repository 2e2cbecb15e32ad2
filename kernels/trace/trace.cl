// Rays through a tree: the closest hit of each, or whether it has one. Every array is a buffer and an offset in bytes.
//
//   in     nodes [node_count]; primitive ids and a mesh (input.clh), or leaf rows (leaf_triangle.clh);
//          a layout's header, nodes and blocks (wide_tree.clh); rays [ray_count] (ray.clh)
//   inout  control [4]: how many rays were left, whether rays go through eight children
//   out    results: Hit, or for any hit uchar (0 or 1) [ray_count]; counts [ray_count] where has_counts
//
// begin_trace, begin_wide_trace
//   set control; one group. The latter asks the layout's header whether there are nodes.
// trace_closest, trace_any
//   launch groups for BLOCK_RAYS rays each
// wide_closest, wide_any
//   the same through eight children, where there are nodes: then those above do nothing
// deep_closest, deep_any
//   trace the rays that were left since they overflowed the private stack, and do nothing where there are none
//   scratch deep_stack [deep_items * deep_capacity], deep_capacity no less than the tree has sibling pairs
//   launch deep_items work items or more
#include "work_group.clh"
#include "aabb.clh"
#include "input.clh"
#include "ray.clh"
#include "ray_box.clh"
#include "ray_triangle.clh"
#include "leaf_triangle.clh"
#include "trace_ray.clh"
#include "wide_tree.clh"

#ifndef BLOCK_RAYS
#define BLOCK_RAYS WORK_GROUP_SIZE
#endif

// Words of control.
#define LEFT_RAYS 0
#define GOES_WIDE 1

// The result of a ray that was left.
#define LEFT_PRIMITIVE (NO_PRIMITIVE - 1)
#define LEFT_ANY 2

typedef struct {
    global uchar* results;
    global uint4* counts;
    uint has_counts;
    int is_any;
} Output;

#define AT(type, buffer, offset) ((global type*)((buffer) + (offset)))

#define SCENE_ARGUMENTS                                                                                                \
    global const uchar *nodes, ulong nodes_offset, uint node_count, global const uchar *ids, ulong ids_offset,         \
        uint form, global const uchar *vertices, ulong vertex_offset, uint vertex_stride, global const uchar *indices, \
        ulong index_offset, uint index_stride, global const uchar *leaf_rows, ulong leaf_rows_offset
#define SCENE                                                                                        \
    {                                                                                                \
        AT(const float4, nodes, nodes_offset), node_count > 0, {                                     \
            input_at(vertices, vertex_offset, vertex_stride, indices, index_offset, index_stride),   \
                AT(const uint, ids, ids_offset), AT(const float4, leaf_rows, leaf_rows_offset), form \
        }                                                                                            \
    }

#define RAY_ARGUMENTS                                                                                                \
    global const uchar *rays_buffer, ulong rays_offset, uint ray_count, global uchar *results, ulong results_offset, \
        global uchar *counts, ulong counts_offset, uint has_counts, global uchar *control_buffer, ulong control_offset
#define RAYS(is_any)                                                                                        \
    global const float4* const rays = AT(const float4, rays_buffer, rays_offset);                           \
    const Output output = {results + results_offset, AT(uint4, counts, counts_offset), has_counts, is_any}; \
    global uint* const control = AT(uint, control_buffer, control_offset)

static inline void store_result(Output output, size_t i, Hit hit, RayCounts counts) {
    if (output.is_any) {
        output.results[i] = hit.primitive != NO_PRIMITIVE;
    } else {
        store_hit((global float4*)output.results, i, hit);
    }
    if (output.has_counts) store_counts(output.counts, i, counts);
}

static inline void leave_ray(Output output, size_t i) {
    if (output.is_any) {
        output.results[i] = LEFT_ANY;
    } else {
        Hit left = no_hit();
        left.primitive = LEFT_PRIMITIVE;
        store_hit((global float4*)output.results, i, left);
    }
}

static inline void store_or_leave(Output output, size_t i, int is_done, Hit hit, RayCounts counts,
                                  global uint* control) {
    if (is_done) {
        store_result(output, i, hit, counts);
    } else {
        leave_ray(output, i);
        atomic_inc(control + LEFT_RAYS);
    }
}

static inline int was_left(Output output, size_t i) {
    return output.is_any ? output.results[i] == LEFT_ANY : ((global const uint4*)output.results)[i].w == LEFT_PRIMITIVE;
}

static inline void trace_rays(Scene scene, global const float4* rays, size_t begin, size_t end, size_t step,
                              Output output, global uint* control) {
    uint2 entries[TRACE_STACK];
    Stack stack = {entries, 0, 0, TRACE_STACK, 0};
    for (size_t i = begin; i < end; i += step) {
        Hit hit;
        RayCounts counts;
        const int is_done = trace_ray(scene, load_ray(rays, i), output.is_any, &stack, &hit, &counts) == TRACE_DONE;
        store_or_leave(output, i, is_done, hit, counts, control);
    }
}

static inline void trace_left(Scene scene, global const float4* rays, uint ray_count, Output output,
                              global uint2* entries, uint items, uint capacity) {
    const size_t item = get_global_id(0);
    if (item >= items) return;
    uint2 none[1];
    Stack stack = {none, entries + item * capacity, 1, capacity, 0};
    for (size_t i = item; i < ray_count; i += items) {
        if (!was_left(output, i)) continue;
        Hit hit;
        RayCounts counts;
        trace_ray(scene, load_ray(rays, i), output.is_any, &stack, &hit, &counts);
        store_result(output, i, hit, counts);
    }
}

#define DEFINE_TRACE(name, is_any)                                                        \
    KERNEL void name(SCENE_ARGUMENTS, RAY_ARGUMENTS) {                                    \
        const Scene scene = SCENE;                                                        \
        RAYS(is_any);                                                                     \
        if (control[GOES_WIDE]) return;                                                   \
        const size_t begin = BLOCK_RAYS * get_group_id(0);                                \
        const size_t end = min(begin + BLOCK_RAYS, (size_t)ray_count);                    \
        trace_rays(scene, rays, begin + LOCAL_ID, end, WORK_GROUP_SIZE, output, control); \
    }

#define DEFINE_DEEP_TRACE(name, is_any)                                                                  \
    KERNEL void name(SCENE_ARGUMENTS, RAY_ARGUMENTS, global uchar* deep_stack, ulong deep_stack_offset,  \
                     uint deep_items, uint deep_capacity) {                                              \
        const Scene scene = SCENE;                                                                       \
        RAYS(is_any);                                                                                    \
        if (control[LEFT_RAYS] == 0) return;                                                             \
        trace_left(scene, rays, ray_count, output, AT(uint2, deep_stack, deep_stack_offset), deep_items, \
                   deep_capacity);                                                                       \
    }

DEFINE_TRACE(trace_closest, 0)
DEFINE_TRACE(trace_any, 1)
DEFINE_DEEP_TRACE(deep_closest, 0)
DEFINE_DEEP_TRACE(deep_any, 1)

KERNEL void begin_trace(global uchar* control_buffer, ulong control_offset) {
    if (LOCAL_ID == 0) *AT(uint4, control_buffer, control_offset) = (uint4)(0, 0, 0, 0);
}

#define WIDE_ARGUMENTS global const uchar *wide, ulong header_offset, ulong wide_nodes_offset, ulong wide_blocks_offset

KERNEL void begin_wide_trace(global uchar* control_buffer, ulong control_offset, WIDE_ARGUMENTS) {
    *AT(uint4, control_buffer, control_offset) =
        (uint4)(0, AT(const uint, wide, header_offset)[LAYOUT_NODE_COUNT], 0, 0);
}

#define DEFINE_WIDE_TRACE(name, is_any)                                                                                \
    KERNEL void name(WIDE_ARGUMENTS, RAY_ARGUMENTS) {                                                                  \
        const WideScene scene = {AT(const float, wide, wide_nodes_offset), AT(const float, wide, wide_blocks_offset)}; \
        RAYS(is_any);                                                                                                  \
        if (!control[GOES_WIDE]) return;                                                                               \
        const size_t begin = BLOCK_RAYS * get_group_id(0);                                                             \
        uint2 stack[WIDE_STACK];                                                                                       \
        FOR_WORK_ITEMS(i, begin, min(begin + BLOCK_RAYS, (size_t)ray_count)) {                                         \
            Hit hit;                                                                                                   \
            const int is_done = trace_wide_ray(scene, load_ray(rays, i), is_any, stack, &hit) == TRACE_DONE;           \
            store_or_leave(output, i, is_done, hit, no_counts(), control);                                             \
        }                                                                                                              \
    }

DEFINE_WIDE_TRACE(wide_closest, 0)
DEFINE_WIDE_TRACE(wide_any, 1)
