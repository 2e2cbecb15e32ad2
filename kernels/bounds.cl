// Boxes of the primitives, and the bounds of the scene and of the centroids.
//
// primitive_bounds
//   in    vertices [.. * 3], triangles [n * 3]
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

#define BOUNDS_FLOATS 12

typedef struct {
    float4 scene_lower, scene_upper, centroid_lower, centroid_upper;  // w is unused
} SceneBounds;

static inline SceneBounds empty_bounds(void) {
    SceneBounds bounds = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    return bounds;
}

static inline SceneBounds merge_bounds(SceneBounds a, SceneBounds b) {
    SceneBounds bounds = {MIN_OF(a.scene_lower, b.scene_lower), MAX_OF(a.scene_upper, b.scene_upper),
                          MIN_OF(a.centroid_lower, b.centroid_lower), MAX_OF(a.centroid_upper, b.centroid_upper)};
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

static inline float4 load_corner(global const float* p) {
    return (float4)(p[0], p[1], p[2], 0.0f);
}

static inline void store_corner(global float* p, float4 corner) {
    p[0] = corner.x;
    p[1] = corner.y;
    p[2] = corner.z;
}

static inline SceneBounds load_bounds(global const float* p) {
    SceneBounds bounds = {load_corner(p), load_corner(p + 3), load_corner(p + 6), load_corner(p + 9)};
    return bounds;
}

static inline void store_bounds(global float* p, SceneBounds bounds) {
    if (LOCAL_ID == 0) {
        store_corner(p, bounds.scene_lower);
        store_corner(p + 3, bounds.scene_upper);
        store_corner(p + 6, bounds.centroid_lower);
        store_corner(p + 9, bounds.centroid_upper);
    }
}

// Adding zero turns -0 into +0, so that equal boxes are equal bits.
static inline float4 load_vertex(global const float* vertices, uint index) {
    return load_corner(vertices + 3 * (size_t)index) + 0.0f;
}

KERNEL void primitive_bounds(global const float* vertices, global const uint* triangles, uint primitive_count,
                             uint piece_length, global float* boxes, global float* partial,
                             global uint* partial_counts) {
    local SceneBounds scratch[WORK_GROUP_SIZE];
    local uint scan[WORK_GROUP_SIZE];
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)primitive_count);
    SceneBounds mine = empty_bounds();
    uint active = 0;
    FOR_WORK_ITEMS(i, begin, end) {
        const float4 a = load_vertex(vertices, triangles[3 * i]);
        const float4 b = load_vertex(vertices, triangles[3 * i + 1]);
        const float4 c = load_vertex(vertices, triangles[3 * i + 2]);
        float4 lower = MIN_OF(MIN_OF(a, b), c);
        float4 upper = MAX_OF(MAX_OF(a, b), c);
        // Coordinates are finite or NaN, and far from overflow, so their sum is NaN where one of them is.
        if (any(isnan((a + b) + c))) {
            lower = upper = NAN;
        } else {
            const float4 centroid = lower + upper;
            const SceneBounds one = {lower, upper, centroid, centroid};
            mine = merge_bounds(mine, one);
            ++active;
        }
        store_corner(boxes + BOX_FLOATS * i, lower);
        store_corner(boxes + BOX_FLOATS * i + 3, upper);
    }
    store_bounds(partial + BOUNDS_FLOATS * get_group_id(0), reduce_over_group(scratch, mine));
    uint total;
    group_exclusive_scan(scan, active, &total);
    if (LOCAL_ID == 0) {
        partial_counts[get_group_id(0)] = total;
    }
}

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
