// 64-bit Morton codes of the primitives' centroids; 63 bits are used.
//
// morton_xyz       21 bits an axis, x above y above z (Lauterbach et al. 2009).
// morton_extended  4D extended code (Vinkler, Bittner, Havran 2017): each bit halves the axis on which the current cell
// is
//                  longest, and every SIZE_BIT_INTERVAL-th bit codes the length of the primitive's diagonal, so that
//                  large primitives part from small ones early.
//   in     boxes [n * 6], bounds [12] as bounds.cl leaves them
//   out    pairs [n]: (low half of the code, primitive); code_low, code_high [n]; inactive primitives get all ones
//   launch groups of WORK_GROUP_SIZE, each on piece_length primitives
// morton_tables    what morton_extended looks bits up in: one group, before it.
//   out    tables [4 * 4 * 256] spread bits of (dimension, byte, value); parameters [12]: lower x y z, three scales,
//   scale of
//          the size, largest values x y z size (as uint)
#include "work_group.clh"
#include "lanes.clh"
#include "aabb.clh"
#include "morton.clh"

#ifndef SIZE_BIT_INTERVAL
#define SIZE_BIT_INTERVAL 7
#endif
#define CODE_BITS 63
#define LARGEST_AXIS_BITS 31
#define DIMENSIONS 4
#define SIZE_DIMENSION 3
#define BYTES_PER_DIMENSION 4

static inline void store_code(global uint2* pairs, global uint* code_low, global uint* code_high, size_t i, uint low,
                              uint high) {
    global uint* pair = (global uint*)(pairs + i);
    pair[0] = low;
    pair[1] = (uint)i;
    code_low[i] = low;
    code_high[i] = high;
}

#define CENTROID_OF(box, axis) ((box).lower_##axis + (box).upper_##axis)
#define AXIS_STEPS (1u << 21)

// How one launch turns centroids into numbers of 21 bits.
typedef struct {
    Box centroids;
    float scale_x, scale_y, scale_z;
} XyzGrid;

static inline XyzGrid load_grid(global const float* bounds) {
    const Box centroids = load_box(bounds + BOX_FLOATS);
    XyzGrid grid = {centroids, quantisation_scale((float)AXIS_STEPS, centroids.upper_x - centroids.lower_x),
                    quantisation_scale((float)AXIS_STEPS, centroids.upper_y - centroids.lower_y),
                    quantisation_scale((float)AXIS_STEPS, centroids.upper_z - centroids.lower_z)};
    return grid;
}

static inline void code_one(XyzGrid grid, global const float* boxes, size_t i, global uint2* pairs,
                            global uint* code_low, global uint* code_high) {
    const Box box = load_box(boxes + BOX_FLOATS * i);
    uint low = INACTIVE_KEY;
    uint high = INACTIVE_KEY;
    if (!is_inactive(box)) {
        const uint x = quantise(CENTROID_OF(box, x) - grid.centroids.lower_x, grid.scale_x, AXIS_STEPS - 1);
        const uint y = quantise(CENTROID_OF(box, y) - grid.centroids.lower_y, grid.scale_y, AXIS_STEPS - 1);
        const uint z = quantise(CENTROID_OF(box, z) - grid.centroids.lower_z, grid.scale_z, AXIS_STEPS - 1);
        low = MORTON_LOW(x, y, z);
        high = MORTON_HIGH(x, y, z);
    }
    store_code(pairs, code_low, code_high, i, low, high);
}

#if LANE_SHAPE
// Numbers of 16 centroids on one axis. A NaN must not reach the conversion, whose result would be undefined.
static inline uint16 quantise16(float16 centroid, float lower, float scale, int16 inactive) {
    const float16 steps = inactive ? (float16)(0.0f) : (centroid - lower) * scale;
    return min(as_uint16(convert_int16_rtz(steps)), AXIS_STEPS - 1);
}

static inline void code_16(XyzGrid grid, global const float* boxes, size_t i, global uint2* pairs,
                           global uint* code_low, global uint* code_high) {
#define BOX_RECORD(k) vload8(0, boxes + BOX_FLOATS * (i + (k)))
    COLUMNS_OF_16_RECORDS(word, BOX_RECORD)
    const int16 inactive = isnan(word0);
    const uint16 x = quantise16(word0 + word3, grid.centroids.lower_x, grid.scale_x, inactive);
    const uint16 y = quantise16(word1 + word4, grid.centroids.lower_y, grid.scale_y, inactive);
    const uint16 z = quantise16(word2 + word5, grid.centroids.lower_z, grid.scale_z, inactive);
    const uint16 low = inactive ? (uint16)(INACTIVE_KEY) : MORTON_LOW(x, y, z);
    const uint16 high = inactive ? (uint16)(INACTIVE_KEY) : MORTON_HIGH(x, y, z);
    const uint16 index = (uint)i + LANES;
    vstore16(low, 0, code_low + i);
    vstore16(high, 0, code_high + i);
    global uint* words = (global uint*)(pairs + i);
    vstore16((uint16)(low.s0, index.s0, low.s1, index.s1, low.s2, index.s2, low.s3, index.s3, low.s4, index.s4, low.s5,
                      index.s5, low.s6, index.s6, low.s7, index.s7),
             0, words);
    vstore16((uint16)(low.s8, index.s8, low.s9, index.s9, low.sa, index.sa, low.sb, index.sb, low.sc, index.sc, low.sd,
                      index.sd, low.se, index.se, low.sf, index.sf),
             1, words);
}
#endif

KERNEL void morton_xyz(global const float* boxes, global const float* bounds, uint primitive_count, uint piece_length,
                       global uint2* pairs, global uint* code_low, global uint* code_high) {
    const XyzGrid grid = load_grid(bounds);
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)primitive_count);
#if LANE_SHAPE
    size_t i = begin;
    // A record is loaded as eight words: the last box has no two more behind it.
    for (; i + 16 < end; i += 16) {
        code_16(grid, boxes, i, pairs, code_low, code_high);
    }
    for (; i < end; ++i) {
        code_one(grid, boxes, i, pairs, code_low, code_high);
    }
#else
    FOR_WORK_ITEMS(i, begin, end) {
        code_one(grid, boxes, i, pairs, code_low, code_high);
    }
#endif
}

// Which dimension each bit of the code belongs to, most significant first, and how many bits each dimension has.
static inline void assign_bits(const float* extents, uchar* dimension_of_bit, uint* bit_count) {
    float cell[3] = {extents[0], extents[1], extents[2]};
    for (uint d = 0; d < DIMENSIONS; ++d) {
        bit_count[d] = 0;
    }
    for (uint k = 0; k < CODE_BITS; ++k) {
        uint dimension = SIZE_DIMENSION;
        if (k % SIZE_BIT_INTERVAL != SIZE_BIT_INTERVAL - 1) {
            float longest = -1.0f;
            for (uint axis = 0; axis < 3; ++axis) {
                if (bit_count[axis] < LARGEST_AXIS_BITS && cell[axis] > longest) {
                    longest = cell[axis];
                    dimension = axis;
                }
            }
            cell[dimension] *= 0.5f;
        }
        dimension_of_bit[k] = (uchar)dimension;
        ++bit_count[dimension];
    }
}

// Where the bits of one byte of one dimension's value stand in the code.
static inline ulong spread_byte(const uchar* dimension_of_bit, uint bit_count, uint dimension, uint byte, uint value) {
    ulong spread = 0;
    uint bit = bit_count;
    for (uint k = 0; k < CODE_BITS; ++k) {
        if (dimension_of_bit[k] == dimension) {
            --bit;
            if (bit / 8 == byte && (value >> (bit % 8) & 1)) {
                spread |= 1ul << (CODE_BITS - 1 - k);
            }
        }
    }
    return spread;
}

static inline float diagonal(float x, float y, float z) {
    return sqrt((x * x + y * y) + z * z);
}

KERNEL void morton_tables(global const float* bounds, global ulong* tables, global float* parameters) {
    const Box scene = load_box(bounds);
    const Box centroids = load_box(bounds + BOX_FLOATS);
    const float lower[3] = {centroids.lower_x, centroids.lower_y, centroids.lower_z};
    const float extents[3] = {centroids.upper_x - centroids.lower_x, centroids.upper_y - centroids.lower_y,
                              centroids.upper_z - centroids.lower_z};
    uchar dimension_of_bit[CODE_BITS];
    uint bit_count[DIMENSIONS];
    assign_bits(extents, dimension_of_bit, bit_count);
    FOR_WORK_ITEMS(k, 0, DIMENSIONS * BYTES_PER_DIMENSION * 256) {
        const uint dimension = (uint)k / (BYTES_PER_DIMENSION * 256);
        tables[k] = spread_byte(dimension_of_bit, bit_count[dimension], dimension, (uint)k / 256 % BYTES_PER_DIMENSION,
                                (uint)k % 256);
    }
    if (LOCAL_ID == 0) {
        const float scene_diagonal =
            diagonal(scene.upper_x - scene.lower_x, scene.upper_y - scene.lower_y, scene.upper_z - scene.lower_z);
        for (uint axis = 0; axis < 3; ++axis) {
            parameters[axis] = lower[axis];
            parameters[3 + axis] = quantisation_scale((float)(1u << bit_count[axis]), extents[axis]);
            parameters[7 + axis] = as_float((1u << bit_count[axis]) - 1);
        }
        parameters[6] = quantisation_scale((float)(1u << bit_count[SIZE_DIMENSION]), scene_diagonal);
        parameters[10] = as_float((1u << bit_count[SIZE_DIMENSION]) - 1);
    }
}

static inline ulong look_up(global const ulong* tables, uint dimension, uint value) {
    global const ulong* table = tables + dimension * BYTES_PER_DIMENSION * 256;
    return table[value & 255] | table[256 + (value >> 8 & 255)] | table[512 + (value >> 16 & 255)] |
           table[768 + (value >> 24)];
}

KERNEL void morton_extended(global const float* boxes, global const ulong* tables, global const float* parameters,
                            uint primitive_count, uint piece_length, global uint2* pairs, global uint* code_low,
                            global uint* code_high) {
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)primitive_count);
    FOR_WORK_ITEMS(i, begin, end) {
        const Box box = load_box(boxes + BOX_FLOATS * i);
        ulong code = ~0ul;
        if (!is_inactive(box)) {
            const float size =
                diagonal(box.upper_x - box.lower_x, box.upper_y - box.lower_y, box.upper_z - box.lower_z);
            code = look_up(tables, 0,
                           quantise(CENTROID_OF(box, x) - parameters[0], parameters[3], as_uint(parameters[7]))) |
                   look_up(tables, 1,
                           quantise(CENTROID_OF(box, y) - parameters[1], parameters[4], as_uint(parameters[8]))) |
                   look_up(tables, 2,
                           quantise(CENTROID_OF(box, z) - parameters[2], parameters[5], as_uint(parameters[9]))) |
                   look_up(tables, SIZE_DIMENSION, quantise(size, parameters[6], as_uint(parameters[10])));
        }
        store_code(pairs, code_low, code_high, i, (uint)code, (uint)(code >> 32));
    }
}
