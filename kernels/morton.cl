// 64-bit Morton codes of the primitives' centroids; 63 bits are used.
//
// morton_xyz       21 bits an axis, x above y above z (Lauterbach et al. 2009).
// morton_extended  4D extended code (Vinkler, Bittner, Havran 2017): each bit halves the axis on which the current cell is
//                  longest, and every SIZE_BIT_INTERVAL-th bit codes the length of the primitive's diagonal, so that large
//                  primitives part from small ones early.
//   in     boxes [n * 6], bounds [12] as bounds.cl leaves them
//   out    pairs [n]: (low half of the code, primitive); code_low, code_high [n]; inactive primitives get all ones
//   launch groups of WORK_GROUP_SIZE, each on piece_length primitives
// morton_tables    what morton_extended looks bits up in: one group, before it.
//   out    tables [4 * 4 * 256] spread bits of (dimension, byte, value); parameters [12]: lower x y z, three scales, scale of
//          the size, largest values x y z size (as uint)
#include "work_group.clh"
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

static inline void store_code(global uint2* pairs, global uint* code_low, global uint* code_high, size_t i, ulong code) {
    const uint low = (uint)code;
    pairs[i] = (uint2)(low, (uint)i);
    code_low[i] = low;
    code_high[i] = (uint)(code >> 32);
}

#define CENTROID_OF(box, axis) ((box).lower_##axis + (box).upper_##axis)

KERNEL void morton_xyz(global const float* boxes, global const float* bounds, uint primitive_count, uint piece_length,
                       global uint2* pairs, global uint* code_low, global uint* code_high) {
    const Box centroids = load_box(bounds + BOX_FLOATS);
    const uint largest = (1u << 21) - 1;
    const float scale_x = quantisation_scale(2097152.0f, centroids.upper_x - centroids.lower_x);
    const float scale_y = quantisation_scale(2097152.0f, centroids.upper_y - centroids.lower_y);
    const float scale_z = quantisation_scale(2097152.0f, centroids.upper_z - centroids.lower_z);
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)primitive_count);
    FOR_WORK_ITEMS(i, begin, end) {
        const Box box = load_box(boxes + BOX_FLOATS * i);
        const int inactive = is_inactive(box);
        // A NaN must not reach the conversion to integer, whose result would be undefined.
        const uint x = inactive ? 0 : quantise(CENTROID_OF(box, x) - centroids.lower_x, scale_x, largest);
        const uint y = inactive ? 0 : quantise(CENTROID_OF(box, y) - centroids.lower_y, scale_y, largest);
        const uint z = inactive ? 0 : quantise(CENTROID_OF(box, z) - centroids.lower_z, scale_z, largest);
        const ulong code = spread_by_3(x) << 2 | spread_by_3(y) << 1 | spread_by_3(z);
        store_code(pairs, code_low, code_high, i, inactive ? INACTIVE_KEY : code);
    }
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

static inline float diagonal(float x, float y, float z) { return sqrt((x * x + y * y) + z * z); }

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
        ulong code = INACTIVE_KEY;
        if (!is_inactive(box)) {
            const float size =
                diagonal(box.upper_x - box.lower_x, box.upper_y - box.lower_y, box.upper_z - box.lower_z);
            code = look_up(tables, 0, quantise(CENTROID_OF(box, x) - parameters[0], parameters[3], as_uint(parameters[7]))) |
                   look_up(tables, 1, quantise(CENTROID_OF(box, y) - parameters[1], parameters[4], as_uint(parameters[8]))) |
                   look_up(tables, 2, quantise(CENTROID_OF(box, z) - parameters[2], parameters[5], as_uint(parameters[9]))) |
                   look_up(tables, SIZE_DIMENSION, quantise(size, parameters[6], as_uint(parameters[10])));
        }
        store_code(pairs, code_low, code_high, i, code);
    }
}
