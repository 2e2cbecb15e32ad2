// 64-bit Morton codes of the primitives' centroids; 63 bits are used, or the leading ones of them.
//
// morton_grid, morton_extended   codes for pairs of 32-bit keys with a value
//   in     boxes [n * 6], bounds [12] as bounds.cl leaves them
//   out    pairs [n]: primitive << 32 | low half of the code; code_low, code_high [n]; inactive primitives get all ones
//   launch groups of WORK_GROUP_SIZE, each on piece_length primitives
// packed_grid, packed_extended   code and primitive in one key, and how many keys have which first digit
//   out    keys [n]: leading code_bits of the code << index_bits | primitive; the largest code is that of inactive
//          primitives alone; counts [RADIX * groups] of the digit at index_bits, digit-major
//   launch as the sort's kernels: one group a piece of the sort
//   local  group shape: RADIX * 4 bytes
// morton_tables    what extended codes are looked up in (morton_extended.clh): one group, before those kernels
#include "work_group.clh"
#include "lanes.clh"
#include "aabb.clh"
#include "morton.clh"
#include "morton_grid.clh"
#include "morton_extended.clh"
#include "packed_key.clh"
#include "radix_digits.clh"

static inline void store_pair(global ulong* pairs, global uint* code_low, global uint* code_high, size_t i,
                              ulong code) {
    pairs[i] = (ulong)i << 32 | (uint)code;
    code_low[i] = (uint)code;
    code_high[i] = (uint)(code >> 32);
}

#if LANE_SHAPE
// How far ahead of their use boxes are fetched.
#ifndef BOX_AHEAD
#define BOX_AHEAD 128
#endif
#define LINE_FLOATS 16

// Fetches the 16 boxes that are BOX_AHEAD behind box i.
static inline void prefetch_boxes(global const float* boxes, size_t i) {
    for (uint line = 0; line < BOX_FLOATS; ++line) {
        PREFETCH(boxes + BOX_FLOATS * (i + BOX_AHEAD) + line * LINE_FLOATS);
    }
}

#define BOX_RECORD(k) vload8(0, boxes + BOX_FLOATS * (i + (k)))

static inline void store_16_pairs(MortonGrid grid, global const float* boxes, size_t i, global ulong* pairs,
                                  global uint* code_low, global uint* code_high) {
    CODES_OF_16_BOXES(grid, BOX_RECORD)
    const uint16 low =
        inactive ? (uint16)((uint)INACTIVE_CODE) : convert_uint16(code << (ulong)grid.unused & 0xfffffffful);
    const uint16 high = inactive ? (uint16)((uint)INACTIVE_CODE) : convert_uint16(code << (ulong)grid.unused >> 32ul);
    vstore16(low, 0, code_low + i);
    vstore16(high, 0, code_high + i);
    vstore16(convert_ulong16((uint)i + LANES) << 32 | convert_ulong16(low), 0, pairs + i);
}
#endif

#define PIECE_OF_PRIMITIVES                                      \
    const size_t begin = get_group_id(0) * (size_t)piece_length; \
    const size_t end = min(begin + piece_length, (size_t)primitive_count);

KERNEL void morton_grid(global const float* boxes, global const float* bounds, uint is_cubic, uint primitive_count,
                        uint piece_length, global ulong* pairs, global uint* code_low, global uint* code_high) {
    PIECE_OF_PRIMITIVES
    MortonGrid grid;
    make_grid(LOWER_CENTROID(bounds), UPPER_CENTROID(bounds), is_cubic, &grid);
    size_t first = begin;
#if LANE_SHAPE
    // A record is loaded as eight words: the last box has no two more behind it.
    for (; first + 16 < end; first += 16) {
        prefetch_boxes(boxes, first);
        store_16_pairs(grid, boxes, first, pairs, code_low, code_high);
    }
#endif
    FOR_WORK_ITEMS(i, first, end) {
        store_pair(pairs, code_low, code_high, i, code_of_record(grid, boxes + BOX_FLOATS * i));
    }
}

KERNEL void morton_extended(global const float* boxes, global const ulong* tables, global const float* parameters,
                            uint primitive_count, uint piece_length, global ulong* pairs, global uint* code_low,
                            global uint* code_high) {
    PIECE_OF_PRIMITIVES
    FOR_WORK_ITEMS(i, begin, end) {
        store_pair(pairs, code_low, code_high, i, extended_code(tables, parameters, boxes + BOX_FLOATS * i));
    }
}

#if LANE_SHAPE
static inline ulong16 pack_16_keys(MortonGrid grid, global const float* boxes, size_t i, uint index_bits,
                                   uint code_bits) {
    CODES_OF_16_BOXES(grid, BOX_RECORD)
    const ulong16 largest = largest_code(code_bits);
    const uint dropped = CODE_BITS - code_bits;
    const ulong16 leading =
        dropped >= grid.unused ? code >> (ulong)(dropped - grid.unused) : code << (ulong)(grid.unused - dropped);
    const ulong16 key = convert_long16(inactive) ? largest : min(leading, largest - 1);
    return key << (ulong)index_bits | convert_ulong16((uint)i + LANES);
}
#endif

KERNEL void packed_grid(global const float* boxes, global const float* bounds, uint is_cubic, uint primitive_count,
                        uint piece_length, uint index_bits, uint code_bits, global ulong* keys, global uint* counts) {
    DIGIT_COUNTERS(counters)
    PIECE_OF_PRIMITIVES
    MortonGrid grid;
    make_grid(LOWER_CENTROID(bounds), UPPER_CENTROID(bounds), is_cubic, &grid);
    size_t first = begin;
    clear_counters(counters);
#if LANE_SHAPE
    // A record is loaded as eight words: the last box has no two more behind it.
    for (; first + 16 < end; first += 16) {
        prefetch_boxes(boxes, first);
        vstore16(pack_16_keys(grid, boxes, first, index_bits, code_bits), 0, keys + first);
        for (size_t i = first; i < first + 16; ++i) {
            COUNT_DIGIT(counters, DIGIT(keys[i], index_bits, RADIX - 1));
        }
    }
#endif
    FOR_WORK_ITEMS(i, first, end) {
        const ulong key = pack_key(code_of_record(grid, boxes + BOX_FLOATS * i), i, index_bits, code_bits);
        COUNT_DIGIT(counters, DIGIT(key, index_bits, RADIX - 1));
        keys[i] = key;
    }
    store_counters(counters, counts);
}

KERNEL void packed_extended(global const float* boxes, global const ulong* tables, global const float* parameters,
                            uint primitive_count, uint piece_length, uint index_bits, uint code_bits,
                            global ulong* keys, global uint* counts) {
    DIGIT_COUNTERS(counters)
    PIECE_OF_PRIMITIVES
    clear_counters(counters);
    FOR_WORK_ITEMS(i, begin, end) {
        const ulong key = pack_key(extended_code(tables, parameters, boxes + BOX_FLOATS * i), i, index_bits, code_bits);
        COUNT_DIGIT(counters, DIGIT(key, index_bits, RADIX - 1));
        keys[i] = key;
    }
    store_counters(counters, counts);
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
