// Boxes of the primitives, and the bounds of the scene and of the centroids.
//
// primitive_bounds
//   in    vertices [.. * 3], triangles [n * 3]
//   out   boxes [n * 6]: NaNs where the primitive is inactive (a coordinate is NaN)
//         partial [groups * 12]: scene lower, scene upper, centroid lower, centroid upper of the group's piece; centroids
//         are doubled (lower + upper)
//   launch groups of WORK_GROUP_SIZE, each on piece_length primitives; any number of groups
//   local  12 * WORK_GROUP_SIZE * 4 bytes
// reduce_bounds
//   in    partial [partial_count * 12]
//   out   bounds [12], in the same order
//   launch one group
#include "work_group.clh"
#include "aabb.clh"

#define BOUNDS_FLOATS 12

typedef struct {
    Box scene;
    Box centroids;
} SceneBounds;

static inline SceneBounds empty_bounds(void) {
    SceneBounds bounds = {empty_box(), empty_box()};
    return bounds;
}

static inline SceneBounds merge_bounds(SceneBounds a, SceneBounds b) {
    SceneBounds bounds = {merge_boxes(a.scene, b.scene), merge_boxes(a.centroids, b.centroids)};
    return bounds;
}

// Merges the items' bounds into item 0's.
static inline SceneBounds reduce_over_group(local SceneBounds* scratch, SceneBounds mine) {
#if !LANE_SHAPE
    const uint item = get_local_id(0);
    scratch[item] = mine;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint half_size = WORK_GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
        if (item < half_size) {
            scratch[item] = merge_bounds(scratch[item], scratch[item + half_size]);
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    mine = scratch[0];
#endif
    return mine;
}

static inline void store_bounds(global float* p, SceneBounds bounds) {
    if (LOCAL_ID == 0) {
        store_box(p, bounds.scene);
        store_box(p + BOX_FLOATS, bounds.centroids);
    }
}

// Adding zero turns -0 into +0, so that equal boxes are equal bits.
static inline Box triangle_box(global const float* vertices, global const uint* triangle) {
    const float3 a = vload3(triangle[0], vertices) + 0.0f;
    const float3 b = vload3(triangle[1], vertices) + 0.0f;
    const float3 c = vload3(triangle[2], vertices) + 0.0f;
    const float3 lower = MIN_OF(MIN_OF(a, b), c);
    const float3 upper = MAX_OF(MAX_OF(a, b), c);
    Box box = {lower.x, lower.y, lower.z, upper.x, upper.y, upper.z};
    if (any(isnan(a)) || any(isnan(b)) || any(isnan(c))) {
        box.lower_x = box.lower_y = box.lower_z = NAN;
        box.upper_x = box.upper_y = box.upper_z = NAN;
    }
    return box;
}

static inline Box centroid_box(Box box) {
    const float x = box.lower_x + box.upper_x;
    const float y = box.lower_y + box.upper_y;
    const float z = box.lower_z + box.upper_z;
    Box point = {x, y, z, x, y, z};
    return point;
}

KERNEL void primitive_bounds(global const float* vertices, global const uint* triangles, uint primitive_count,
                             uint piece_length, global float* boxes, global float* partial) {
    local SceneBounds scratch[WORK_GROUP_SIZE];
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)primitive_count);
    SceneBounds mine = empty_bounds();
    FOR_WORK_ITEMS(i, begin, end) {
        const Box box = triangle_box(vertices, triangles + 3 * i);
        store_box(boxes + BOX_FLOATS * i, box);
        if (!is_inactive(box)) {
            const SceneBounds one = {box, centroid_box(box)};
            mine = merge_bounds(mine, one);
        }
    }
    store_bounds(partial + BOUNDS_FLOATS * get_group_id(0), reduce_over_group(scratch, mine));
}

KERNEL void reduce_bounds(global const float* partial, uint partial_count, global float* bounds) {
    local SceneBounds scratch[WORK_GROUP_SIZE];
    SceneBounds mine = empty_bounds();
    FOR_WORK_ITEMS(i, 0, partial_count) {
        const SceneBounds one = {load_box(partial + BOUNDS_FLOATS * i),
                                 load_box(partial + BOUNDS_FLOATS * i + BOX_FLOATS)};
        mine = merge_bounds(mine, one);
    }
    store_bounds(bounds, reduce_over_group(scratch, mine));
}
