// One pass of a stable LSD radix sort of 64-bit elements by the digit (element >> shift) & mask.
//
// Packed keys (morton.cl) are sorted in one block of passes over the bits of the code. Pairs of a 32-bit key and a
// 32-bit value (value << 32 | key) take two blocks, one over each half of the code, so that a sorted element stays 8
// bytes (PLOC++ section 5). Replacing the low half of the code by the high half between the blocks costs no pass: the
// last scatter of the first block does it.
//
// The elements are cut into pieces of piece_length, one work group each, which count [RADIX * pieces] digits.
// count_digits    in elements  out counts
// scan_digits     group shape only: counts become the first position of each (digit, piece); one group
// scatter         in elements, counts  out elements
// scatter_ids     packed: the same, and ids [n] = the bits of index_mask
// scatter_rekey   pairs: as scatter, and the key becomes next_keys[value]
// scatter_last    pairs: splits the pair: values alone, and codes [n] = key << 32 | code_low[value]
//
// local   group shape: TILE * 8 + LOCAL_DIGITS * WORK_GROUP_SIZE * 2 + 3 * RADIX * 4 bytes; lane shape: none
#include "work_group.clh"
#include "scan.clh"
#include "radix_digits.clh"

// How far ahead of its use an element is fetched.
#ifndef SORT_AHEAD
#define SORT_AHEAD 128
#endif

#define PIECE_OF_ELEMENTS                                        \
    const size_t begin = get_group_id(0) * (size_t)piece_length; \
    const size_t end = min(begin + piece_length, (size_t)element_count);

KERNEL void count_digits(global const ulong* elements, uint element_count, uint piece_length, uint shift, uint mask,
                         global uint* counts) {
    DIGIT_COUNTERS(counters)
    PIECE_OF_ELEMENTS
    clear_counters(counters);
    FOR_WORK_ITEMS(i, begin, end) {
        PREFETCH(elements + i + SORT_AHEAD);
        COUNT_DIGIT(counters, DIGIT(elements[i], shift, mask));
    }
    store_counters(counters, counts);
}

// Kinds of store at an element's new place; each of the four kernels is compiled for its own.
#define SCATTER_PLAIN 0
#define SCATTER_IDS 1
#define SCATTER_REKEY 2
#define SCATTER_LAST 3
#define NEEDS_HALVES(kind) ((kind) == SCATTER_REKEY || (kind) == SCATTER_LAST)

#define VALUE(element) ((uint)((element) >> 32))

// Where elements go, and what they are made of there; what a kind does not need is null.
typedef struct {
    global ulong* elements;     // or codes
    global uint* words;         // ids or values
    global const uint* halves;  // next keys, or the low halves of the codes, by value
    uint index_mask;
} Target;

static inline void store_element(uint kind, Target target, uint at, ulong element) {
    if (kind == SCATTER_REKEY) {
        target.elements[at] = (element & ~0xfffffffful) | target.halves[VALUE(element)];
    } else if (kind == SCATTER_LAST) {
        target.words[at] = VALUE(element);
        target.elements[at] = element << 32 | target.halves[VALUE(element)];
    } else {
        target.elements[at] = element;
        if (kind == SCATTER_IDS) target.words[at] = (uint)element & target.index_mask;
    }
}

#if LANE_SHAPE

// How far ahead of its use a gathered word is fetched.
#ifndef HALF_AHEAD
#define HALF_AHEAD 16
#endif

typedef struct {
    uint* next;  // [RADIX] where the next element of each digit goes
} ScatterScratch;

#define DECLARE_SCATTER_SCRATCH(scratch) \
    uint scratch##_next[RADIX];          \
    const ScatterScratch scratch = {scratch##_next};

// First position of each digit of this piece.
static inline void find_positions(global const uint* counts, ScatterScratch scratch) {
    uint* const next = scratch.next;
    uint total[RADIX];
    for (size_t digit = 0; digit < RADIX; ++digit) {
        next[digit] = total[digit] = 0;
    }
    for (size_t piece = 0; piece < get_num_groups(0); ++piece) {
        const uint is_before = piece < get_group_id(0) ? 0xffffffffu : 0;
        for (size_t digit = 0; digit < RADIX; ++digit) {
            const uint count = counts[piece * RADIX + digit];
            total[digit] += count;
            next[digit] += count & is_before;
        }
    }
    uint smaller = 0;
    for (size_t digit = 0; digit < RADIX; ++digit) {
        next[digit] += smaller;
        smaller += total[digit];
    }
}

// The elements of a cache line: how far ahead of a write the memory behind it is fetched.
#define LINE_ELEMENTS 8

// `kind` is a constant, as in store_element().
static inline void scatter_piece(uint kind, global const ulong* elements, size_t begin, size_t end, uint shift,
                                 uint mask, ScatterScratch scratch, Target target) {
    for (size_t i = begin; i < end; ++i) {
        const ulong element = elements[i];
        PREFETCH(elements + i + SORT_AHEAD);
        if (NEEDS_HALVES(kind)) PREFETCH(target.halves + VALUE(elements[min(i + HALF_AHEAD, end - 1)]));
        const uint at = scratch.next[DIGIT(element, shift, mask)]++;
        PREFETCH(target.elements + at + LINE_ELEMENTS);
        if (kind == SCATTER_IDS) PREFETCH(target.words + at + 2 * LINE_ELEMENTS);
        store_element(kind, target, at, element);
    }
}

#else

// Each item sums a contiguous run, the group scans the sums, each item writes its run.
KERNEL void scan_digits(global uint* counts, uint count) {
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

// A tile of TILE elements at a time is sorted by its digit in local memory, four bits after four, so that equal digits
// leave in runs; then every run is written to where the group's next element of that digit belongs (Satish, Harris,
// Garland 2009).
#define TILE (WORK_GROUP_SIZE * TILE_ELEMENTS_PER_ITEM)
#define LOCAL_BITS 4
#define LOCAL_DIGITS (1 << LOCAL_BITS)

// Four bits of an element's digit.
static inline uint local_digit(ulong element, uint shift, uint mask, uint local_shift) {
    return DIGIT(element, shift, mask) >> local_shift & (LOCAL_DIGITS - 1);
}

// Stable order of the tile by four bits. Elements beyond the input carry the largest digit and stay last.
static inline void sort_tile(local ulong* tile, local ushort* counters, local uint* scratch, uint shift, uint mask,
                             uint local_shift) {
    const uint item = get_local_id(0);
    ulong mine[TILE_ELEMENTS_PER_ITEM];
    for (uint k = 0; k < LOCAL_DIGITS; ++k) {
        counters[k * WORK_GROUP_SIZE + item] = 0;
    }
    for (uint k = 0; k < TILE_ELEMENTS_PER_ITEM; ++k) {
        mine[k] = tile[item * TILE_ELEMENTS_PER_ITEM + k];
        ++counters[local_digit(mine[k], shift, mask, local_shift) * WORK_GROUP_SIZE + item];
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
    for (uint k = 0; k < TILE_ELEMENTS_PER_ITEM; ++k) {
        const uint at = local_digit(mine[k], shift, mask, local_shift) * WORK_GROUP_SIZE + item;
        tile[counters[at]] = mine[k];
        ++counters[at];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

typedef struct {
    local ulong* tile;       // [TILE]
    local ushort* counters;  // [LOCAL_DIGITS * WORK_GROUP_SIZE]
    local uint* sums;        // [WORK_GROUP_SIZE]
    local uint* next;        // [RADIX] where the next element of each digit goes
    local uint* run_begin;   // [RADIX] of each digit's run in the tile
    local uint* run_end;     // [RADIX]
} ScatterScratch;

#define DECLARE_SCATTER_SCRATCH(scratch)                                                 \
    local ulong scratch##_tile[TILE];                                                    \
    local ushort scratch##_counters[LOCAL_DIGITS * WORK_GROUP_SIZE];                     \
    local uint scratch##_sums[WORK_GROUP_SIZE];                                          \
    local uint scratch##_next[RADIX];                                                    \
    local uint scratch##_run_begin[RADIX];                                               \
    local uint scratch##_run_end[RADIX];                                                 \
    const ScatterScratch scratch = {scratch##_tile, scratch##_counters,  scratch##_sums, \
                                    scratch##_next, scratch##_run_begin, scratch##_run_end};

// First position of each digit of this piece. Needs a barrier behind it.
static inline void find_positions(global const uint* counts, ScatterScratch scratch) {
    FOR_WORK_ITEMS(digit, 0, RADIX) {
        scratch.next[digit] = counts[COUNT_PLACE(digit)];
    }
}

// Loads and sorts the tile at `at`, and finds the run of each digit.
static inline void load_tile(global const ulong* elements, size_t at, size_t end, uint shift, uint mask,
                             ScatterScratch scratch) {
    local ulong* const tile = scratch.tile;
    FOR_WORK_ITEMS(k, 0, TILE) {
        tile[k] = at + k < end ? elements[at + k] : ~0ul;
    }
    FOR_WORK_ITEMS(digit, 0, RADIX) {
        scratch.run_begin[digit] = scratch.run_end[digit] = 0;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint local_shift = 0; local_shift < RADIX_BITS; local_shift += LOCAL_BITS) {
        sort_tile(tile, scratch.counters, scratch.sums, shift, mask, local_shift);
    }
    FOR_WORK_ITEMS(k, 0, TILE) {
        const uint digit = DIGIT(tile[k], shift, mask);
        if (k == 0 || DIGIT(tile[k - 1], shift, mask) != digit) {
            scratch.run_begin[digit] = (uint)k;
        }
        if (k == TILE - 1 || DIGIT(tile[k + 1], shift, mask) != digit) {
            scratch.run_end[digit] = (uint)k + 1;
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// `kind` is a constant, as in store_element(). Padding ends the tile that holds the piece's end.
static inline void scatter_piece(uint kind, global const ulong* elements, size_t begin, size_t end, uint shift,
                                 uint mask, ScatterScratch scratch, Target target) {
    for (size_t tile_begin = begin; tile_begin < end; tile_begin += TILE) {
        load_tile(elements, tile_begin, end, shift, mask, scratch);
        FOR_WORK_ITEMS(k, 0, min((size_t)TILE, end - tile_begin)) {
            const ulong element = scratch.tile[k];
            const uint digit = DIGIT(element, shift, mask);
            store_element(kind, target, scratch.next[digit] + (uint)k - scratch.run_begin[digit], element);
        }
        barrier(CLK_LOCAL_MEM_FENCE);
        FOR_WORK_ITEMS(digit, 0, RADIX) {
            scratch.next[digit] += scratch.run_end[digit] - scratch.run_begin[digit];
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

#endif

// The body of all four kernels; declares variables.
#define SCATTER_PIECE(kind, target)  \
    PIECE_OF_ELEMENTS                \
    DECLARE_SCATTER_SCRATCH(scratch) \
    find_positions(counts, scratch); \
    scatter_piece(kind, elements, begin, end, shift, mask, scratch, target)

KERNEL void scatter(global const ulong* elements, uint element_count, uint piece_length, uint shift, uint mask,
                    global const uint* counts, global ulong* elements_out) {
    const Target target = {elements_out, 0, 0, 0};
    SCATTER_PIECE(SCATTER_PLAIN, target);
}

KERNEL void scatter_ids(global const ulong* elements, uint element_count, uint piece_length, uint shift, uint mask,
                        global const uint* counts, uint index_mask, global ulong* elements_out, global uint* ids) {
    const Target target = {elements_out, ids, 0, index_mask};
    SCATTER_PIECE(SCATTER_IDS, target);
}

KERNEL void scatter_rekey(global const ulong* elements, uint element_count, uint piece_length, uint shift, uint mask,
                          global const uint* counts, global const uint* next_keys, global ulong* elements_out) {
    const Target target = {elements_out, 0, next_keys, 0};
    SCATTER_PIECE(SCATTER_REKEY, target);
}

KERNEL void scatter_last(global const ulong* elements, uint element_count, uint piece_length, uint shift, uint mask,
                         global const uint* counts, global const uint* code_low, global ulong* codes_out,
                         global uint* values_out) {
    const Target target = {codes_out, values_out, code_low, 0};
    SCATTER_PIECE(SCATTER_LAST, target);
}
