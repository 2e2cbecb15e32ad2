// Rays through a tree: the closest hit of each, or whether it has one. Every array is a buffer, and an offset in bytes
// of ScenePlace, LayoutPlace (layout_constants.h) or RaysPlace (trace_constants.h).
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
#include "place.clh"
#include "layout_constants.h"
#include "trace_constants.h"
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

static inline Scene scene_at(ScenePlace place, global const uchar* nodes, global const uchar* primitive_ids,
                             global const uchar* vertices, global const uchar* indices, global const uchar* layout,
                             LayoutPlace layout_place) {
    Scene scene;
    scene.nodes = AT(const float4, nodes, place.nodes);
    scene.has_nodes = place.node_count > 0;
    scene.triangles.input =
        input_at(vertices, place.vertices, place.vertex_stride, indices, place.indices, place.index_stride);
    scene.triangles.primitive_ids = AT(const uint, primitive_ids, place.primitive_ids);
    scene.triangles.leaf_rows = AT(const float4, layout, layout_place.rows);
    scene.triangles.form = place.form;
    return scene;
}

static inline Output output_at(RaysPlace place, global uchar* results, global uchar* counts, int is_any) {
    Output output = {results + place.results, AT(uint4, counts, place.counts), place.has_counts, is_any};
    return output;
}

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

#define DEFINE_TRACE(name, is_any)                                                                                    \
    KERNEL void name(global const uchar* nodes, global const uchar* primitive_ids, global const uchar* vertices,      \
                     global const uchar* indices, ScenePlace scene_place, global const uchar* layout,                 \
                     LayoutPlace layout_place, global const uchar* rays, global uchar* results, global uchar* counts, \
                     global uchar* control, RaysPlace rays_place) {                                                   \
        global uint* const words = AT(uint, control, rays_place.control);                                             \
        if (words[GOES_WIDE]) return;                                                                                 \
        const Scene scene = scene_at(scene_place, nodes, primitive_ids, vertices, indices, layout, layout_place);     \
        const size_t begin = BLOCK_RAYS * get_group_id(0);                                                            \
        const size_t end = min(begin + BLOCK_RAYS, (size_t)rays_place.ray_count);                                     \
        trace_rays(scene, AT(const float4, rays, rays_place.rays), begin + LOCAL_ID, end, WORK_GROUP_SIZE,            \
                   output_at(rays_place, results, counts, is_any), words);                                            \
    }

#define DEFINE_DEEP_TRACE(name, is_any)                                                                               \
    KERNEL void name(global const uchar* nodes, global const uchar* primitive_ids, global const uchar* vertices,      \
                     global const uchar* indices, ScenePlace scene_place, global const uchar* layout,                 \
                     LayoutPlace layout_place, global const uchar* rays, global uchar* results, global uchar* counts, \
                     global uchar* control, RaysPlace rays_place, global uchar* deep_stack, ulong deep_stack_offset,  \
                     uint deep_items, uint deep_capacity) {                                                           \
        if (AT(uint, control, rays_place.control)[LEFT_RAYS] == 0) return;                                            \
        const Scene scene = scene_at(scene_place, nodes, primitive_ids, vertices, indices, layout, layout_place);     \
        trace_left(scene, AT(const float4, rays, rays_place.rays), rays_place.ray_count,                              \
                   output_at(rays_place, results, counts, is_any), AT(uint2, deep_stack, deep_stack_offset),          \
                   deep_items, deep_capacity);                                                                        \
    }

DEFINE_TRACE(trace_closest, 0)
DEFINE_TRACE(trace_any, 1)
DEFINE_DEEP_TRACE(deep_closest, 0)
DEFINE_DEEP_TRACE(deep_any, 1)

KERNEL void begin_trace(global uchar* control, RaysPlace rays_place) {
    if (LOCAL_ID == 0) *AT(uint4, control, rays_place.control) = (uint4)(0, 0, 0, 0);
}

KERNEL void begin_wide_trace(global const uchar* layout, LayoutPlace layout_place, global uchar* control,
                             RaysPlace rays_place) {
    *AT(uint4, control, rays_place.control) =
        (uint4)(0, AT(const uint, layout, layout_place.header)[LAYOUT_NODE_COUNT], 0, 0);
}

#define DEFINE_WIDE_TRACE(name, is_any)                                                                          \
    KERNEL void name(global const uchar* layout, LayoutPlace layout_place, global const uchar* rays_buffer,      \
                     global uchar* results, global uchar* counts, global uchar* control, RaysPlace rays_place) { \
        const WideScene scene = {AT(const float, layout, layout_place.nodes),                                    \
                                 AT(const float, layout, layout_place.blocks)};                                  \
        global const float4* const rays = AT(const float4, rays_buffer, rays_place.rays);                        \
        const Output output = output_at(rays_place, results, counts, is_any);                                    \
        global uint* const words = AT(uint, control, rays_place.control);                                        \
        if (!words[GOES_WIDE]) return;                                                                           \
        const size_t begin = BLOCK_RAYS * get_group_id(0);                                                       \
        uint2 stack[WIDE_STACK];                                                                                 \
        FOR_WORK_ITEMS(i, begin, min(begin + BLOCK_RAYS, (size_t)rays_place.ray_count)) {                        \
            Hit hit;                                                                                             \
            const int is_done = trace_wide_ray(scene, load_ray(rays, i), is_any, stack, &hit) == TRACE_DONE;     \
            store_or_leave(output, i, is_done, hit, no_counts(), words);                                         \
        }                                                                                                        \
    }

DEFINE_WIDE_TRACE(wide_closest, 0)
DEFINE_WIDE_TRACE(wide_any, 1)
