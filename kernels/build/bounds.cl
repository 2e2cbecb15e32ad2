// Boxes of the primitives, and the bounds of the scene and of the centroids.
//
// primitive_bounds, and one of the same for every other form of input
//   in    vertices and indices, or boxes (input.clh)
//   out   boxes [n * 6]: NaNs where the primitive is inactive (a coordinate is NaN)
//         partial [groups * 12]: scene lower, scene upper, centroid lower, centroid upper of the group's piece;
//         centroids are doubled (lower + upper); partial_counts [groups]: its active primitives
//   launch groups of WORK_GROUP_SIZE, each on piece_length primitives; any number of groups
//   local  16 * WORK_GROUP_SIZE * 4 bytes
// reduce_bounds
//   in    partial [partial_count * 12], partial_counts [partial_count]
//   out   bounds [12], in the same order; leaf_count [1]: the active primitives of all
//   launch one group
#include "work_group.clh"
#include "aabb.clh"
#include "scan.clh"
#include "input.clh"
#include "scene_bounds.clh"

#define DEFINE_PRIMITIVE_BOUNDS(name, form)                                                                        \
    KERNEL void name(global const uchar* vertices, ulong vertex_offset, uint vertex_stride,                        \
                     global const uchar* indices, ulong index_offset, uint index_stride, uint primitive_count,     \
                     uint piece_length, global float* boxes, global float* partial, global uint* partial_counts) { \
        local SceneBounds scratch[WORK_GROUP_SIZE];                                                                \
        local uint scan[WORK_GROUP_SIZE];                                                                          \
        const Input input = input_at(vertices, vertex_offset, vertex_stride, indices, index_offset, index_stride); \
        const size_t begin = get_group_id(0) * (size_t)piece_length;                                               \
        SceneBounds mine;                                                                                          \
        const uint active =                                                                                        \
            bounds_of_piece(input, form, begin, min(begin + piece_length, (size_t)primitive_count), boxes, &mine); \
        store_bounds(partial + BOUNDS_FLOATS * get_group_id(0), reduce_over_group(scratch, mine));                 \
        uint total;                                                                                                \
        group_exclusive_scan(scan, active, &total);                                                                \
        if (LOCAL_ID == 0) {                                                                                       \
            partial_counts[get_group_id(0)] = total;                                                               \
        }                                                                                                          \
    }

DEFINE_PRIMITIVE_BOUNDS(primitive_bounds, INPUT_TIGHT)
DEFINE_PRIMITIVE_BOUNDS(indexed_32_bounds, INPUT_INDEXED_32)
DEFINE_PRIMITIVE_BOUNDS(indexed_16_bounds, INPUT_INDEXED_16)
DEFINE_PRIMITIVE_BOUNDS(triangle_bounds, INPUT_TRIANGLES)
DEFINE_PRIMITIVE_BOUNDS(box_bounds, INPUT_BOXES)

KERNEL void reduce_bounds(global const float* partial, global const uint* partial_counts, uint partial_count,
                          global float* bounds, global uint* leaf_count) {
    local SceneBounds scratch[WORK_GROUP_SIZE];
    local uint scan[WORK_GROUP_SIZE];
    SceneBounds mine = empty_bounds();
    uint active = 0;
    FOR_WORK_ITEMS(i, 0, partial_count) {
        mine = merge_bounds(mine, load_bounds(partial + BOUNDS_FLOATS * i));
        active += partial_counts[i];
    }
    store_bounds(bounds, reduce_over_group(scratch, mine));
    uint total;
    group_exclusive_scan(scan, active, &total);
    if (LOCAL_ID == 0) {
        *leaf_count = total;
    }
}
