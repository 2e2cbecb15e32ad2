// One pass of a stable LSD radix sort of (32-bit key, 32-bit value) pairs by one 8-bit digit. Eight passes sort 64-bit
// codes: two blocks of four passes over one half of the code each, so that a sorted element stays 8 bytes (PLOC++
// section 5). Replacing the low half of the code by the high half between the blocks costs no pass: the fourth scatter
// does it.
//
// The keys are cut into pieces of piece_length, one work group each; counts are kept digit-major, [RADIX * pieces].
// count_digits    in pairs  out counts
// scan_counts     group shape only: counts become the first position of each (digit, piece); one group
// scatter         in pairs, counts  out pairs
// scatter_rekey   the same, and the key becomes next_keys[value]
// scatter_last    the same, but splits the pair: values alone, and codes [n] = key << 32 | code_low[value]
//
// local   group shape: TILE * 8 + LOCAL_DIGITS * WORK_GROUP_SIZE * 2 + 3 * RADIX * 4 bytes; lane shape: none
#include "work_group.clh"
#include "scan.clh"

#define RADIX_BITS 8
#define RADIX (1 << RADIX_BITS)
#define DIGIT(key, shift) ((key) >> (shift) & (RADIX - 1))

KERNEL void count_digits(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                         global uint* counts) {
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)pair_count);
#if LANE_SHAPE
    uint digit_count[RADIX];
    for (size_t digit = 0; digit < RADIX; ++digit) {
        digit_count[digit] = 0;
    }
    for (size_t i = begin; i < end; ++i) {
        ++digit_count[DIGIT(pairs[i].x, shift)];
    }
#else
    local uint digit_count[RADIX];
    FOR_WORK_ITEMS(digit, 0, RADIX) {
        digit_count[digit] = 0;
    }
    LOCAL_BARRIER();
    FOR_WORK_ITEMS(i, begin, end) {
        atomic_inc(digit_count + DIGIT(pairs[i].x, shift));
    }
    LOCAL_BARRIER();
#endif
    FOR_WORK_ITEMS(digit, 0, RADIX) {
        counts[digit * get_num_groups(0) + get_group_id(0)] = digit_count[digit];
    }
}

#if LANE_SHAPE

// How far ahead of its use a gathered word is fetched.
#ifndef GATHER_AHEAD
#define GATHER_AHEAD 16
#endif

// First position of each digit of this piece. The pieces are few, so every one sums all their counts itself.
static inline void find_positions(global const uint* counts, uint* position) {
    const size_t pieces = get_num_groups(0);
    const size_t piece = get_group_id(0);
    uint before = 0;
    for (size_t digit = 0; digit < RADIX; ++digit) {
        uint digit_total = 0;
        for (size_t k = 0; k < pieces; ++k) {
            position[digit] = k == piece ? before + digit_total : position[digit];
            digit_total += counts[digit * pieces + k];
        }
        before += digit_total;
    }
}

#define LOAD_POSITIONS(position) \
    uint position[RADIX];        \
    find_positions(counts, position);

KERNEL void scatter(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                    global const uint* counts, global uint2* pairs_out) {
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)pair_count);
    LOAD_POSITIONS(position)
    for (size_t i = begin; i < end; ++i) {
        const uint2 pair = pairs[i];
        pairs_out[position[DIGIT(pair.x, shift)]++] = pair;
    }
}

KERNEL void scatter_rekey(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                          global const uint* counts, global uint2* pairs_out, global const uint* next_keys) {
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)pair_count);
    LOAD_POSITIONS(position)
    for (size_t i = begin; i < end; ++i) {
        const uint2 pair = pairs[i];
        PREFETCH(next_keys + pairs[min(i + GATHER_AHEAD, end - 1)].y);
        pairs_out[position[DIGIT(pair.x, shift)]++] = (uint2)(next_keys[pair.y], pair.y);
    }
}

KERNEL void scatter_last(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                         global const uint* counts, global const uint* code_low, global uint* values_out,
                         global ulong* codes_out) {
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    const size_t end = min(begin + piece_length, (size_t)pair_count);
    LOAD_POSITIONS(position)
    for (size_t i = begin; i < end; ++i) {
        const uint2 pair = pairs[i];
        PREFETCH(code_low + pairs[min(i + GATHER_AHEAD, end - 1)].y);
        const uint at = position[DIGIT(pair.x, shift)]++;
        values_out[at] = pair.y;
        codes_out[at] = (ulong)pair.x << 32 | code_low[pair.y];
    }
}

#else

// Each item sums a contiguous run, the group scans the sums, each item writes its run.
KERNEL void scan_counts(global uint* counts, uint count) {
    local uint scratch[WORK_GROUP_SIZE];
    const uint run = (count + WORK_GROUP_SIZE - 1) / WORK_GROUP_SIZE;
    const uint begin = min((uint)LOCAL_ID * run, count);
    const uint end = min(begin + run, count);
    uint sum = 0;
    for (uint i = begin; i < end; ++i) {
        sum += counts[i];
    }
    uint total;
    uint before = group_exclusive_scan(scratch, sum, &total);
    for (uint i = begin; i < end; ++i) {
        const uint here = counts[i];
        counts[i] = before;
        before += here;
    }
}

// A tile of TILE pairs at a time is sorted by its digit in local memory, four bits after four, so that equal digits
// leave in runs; then every run is written to where the group's next pair of that digit belongs (Satish, Harris,
// Garland 2009).
#ifndef ITEMS_PER_WORK_ITEM
#define ITEMS_PER_WORK_ITEM 4
#endif
#define TILE (WORK_GROUP_SIZE * ITEMS_PER_WORK_ITEM)
#define LOCAL_DIGITS 16

// Stable order of the tile by the four bits at `shift`. Pairs beyond the input carry the largest digit and stay last.
static inline void sort_tile(local uint2* tile, local ushort* counters, local uint* scratch, uint shift) {
    const uint item = get_local_id(0);
    uint2 mine[ITEMS_PER_WORK_ITEM];
    for (uint k = 0; k < LOCAL_DIGITS; ++k) {
        counters[k * WORK_GROUP_SIZE + item] = 0;
    }
    for (uint k = 0; k < ITEMS_PER_WORK_ITEM; ++k) {
        mine[k] = tile[item * ITEMS_PER_WORK_ITEM + k];
        ++counters[(mine[k].x >> shift & (LOCAL_DIGITS - 1)) * WORK_GROUP_SIZE + item];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint sum = 0;
    for (uint k = 0; k < LOCAL_DIGITS; ++k) {
        sum += counters[item * LOCAL_DIGITS + k];
    }
    uint total;
    uint before = group_exclusive_scan(scratch, sum, &total);
    for (uint k = 0; k < LOCAL_DIGITS; ++k) {
        const uint here = counters[item * LOCAL_DIGITS + k];
        counters[item * LOCAL_DIGITS + k] = (ushort)before;
        before += here;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = 0; k < ITEMS_PER_WORK_ITEM; ++k) {
        const uint at = (mine[k].x >> shift & (LOCAL_DIGITS - 1)) * WORK_GROUP_SIZE + item;
        tile[counters[at]] = mine[k];
        ++counters[at];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

#define SCATTER_LOCALS                                                     \
    local uint2 tile[TILE];                                                \
    local ushort counters[LOCAL_DIGITS * WORK_GROUP_SIZE];                 \
    local uint scratch[WORK_GROUP_SIZE];                                   \
    local uint next[RADIX];                                                \
    local uint run_begin[RADIX];                                           \
    local uint run_end[RADIX];                                             \
    const size_t begin = get_group_id(0) * (size_t)piece_length;           \
    const size_t end = min(begin + piece_length, (size_t)pair_count);      \
    FOR_WORK_ITEMS(digit, 0, RADIX) {                                      \
        next[digit] = counts[digit * get_num_groups(0) + get_group_id(0)]; \
    }

// Loads and sorts the tile at `at`, and finds the run of each digit.
static inline void load_tile(global const uint2* pairs, size_t at, size_t end, uint shift, local uint2* tile,
                             local ushort* counters, local uint* scratch, local uint* run_begin, local uint* run_end) {
    FOR_WORK_ITEMS(k, 0, TILE) {
        tile[k] = at + k < end ? pairs[at + k] : (uint2)(0xffffffffu, 0xffffffffu);
    }
    FOR_WORK_ITEMS(digit, 0, RADIX) {
        run_begin[digit] = run_end[digit] = 0;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    sort_tile(tile, counters, scratch, shift);
    sort_tile(tile, counters, scratch, shift + 4);
    FOR_WORK_ITEMS(k, 0, TILE) {
        const uint digit = DIGIT(tile[k].x, shift);
        if (k == 0 || DIGIT(tile[k - 1].x, shift) != digit) {
            run_begin[digit] = (uint)k;
        }
        if (k == TILE - 1 || DIGIT(tile[k + 1].x, shift) != digit) {
            run_end[digit] = (uint)k + 1;
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// for every pair of the piece: `at` is where it belongs. Padding pairs end the tile that holds the piece's end.
#define FOR_SCATTERED_PAIRS(store)                                                             \
    for (size_t tile_begin = begin; tile_begin < end; tile_begin += TILE) {                    \
        load_tile(pairs, tile_begin, end, shift, tile, counters, scratch, run_begin, run_end); \
        FOR_WORK_ITEMS(k, 0, min((size_t)TILE, end - tile_begin)) {                            \
            const uint2 pair = tile[k];                                                        \
            const uint digit = DIGIT(pair.x, shift);                                           \
            const uint at = next[digit] + (uint)k - run_begin[digit];                          \
            store                                                                              \
        }                                                                                      \
        barrier(CLK_LOCAL_MEM_FENCE);                                                          \
        FOR_WORK_ITEMS(digit, 0, RADIX) {                                                      \
            next[digit] += run_end[digit] - run_begin[digit];                                  \
        }                                                                                      \
        barrier(CLK_LOCAL_MEM_FENCE);                                                          \
    }

KERNEL void scatter(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                    global const uint* counts, global uint2* pairs_out) {
    SCATTER_LOCALS
    FOR_SCATTERED_PAIRS(pairs_out[at] = pair;)
}

KERNEL void scatter_rekey(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                          global const uint* counts, global uint2* pairs_out, global const uint* next_keys) {
    SCATTER_LOCALS
    FOR_SCATTERED_PAIRS(vstore2((uint2)(next_keys[pair.y], pair.y), at, (global uint*)pairs_out);)
}

KERNEL void scatter_last(global const uint2* pairs, uint pair_count, uint piece_length, uint shift,
                         global const uint* counts, global const uint* code_low, global uint* values_out,
                         global ulong* codes_out) {
    SCATTER_LOCALS
    FOR_SCATTERED_PAIRS(values_out[at] = pair.y; codes_out[at] = (ulong)pair.x << 32 | code_low[pair.y];)
}

#endif
