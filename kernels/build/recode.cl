// Codes again where many primitives share one: around a far triangle, or in a town on a globe, all of an object may lie
// in one cell of the scene's grid. Each run of more than LONGEST_RUN equal codes gets a grid over its own centroids,
// and its codes there take the place of the low bits, which told its keys apart by their primitives.
//
// Where a run is long these bits are too few. Then all keys are packed: bits that are not the highest to differ between
// any two neighbours decide nothing, neither the order nor the tree over it, and are left out.
//
// Per round, over codes [leaf_count], sorted and all different, and primitive_ids in that order:
//   find_runs     out    runs [2 * ..]: begin and length of each; state: how many, the longest
//   find_levels   inout  state: the bits that decide something
//   pack_codes    inout  codes
//   recode_runs   inout  codes, primitive_ids; keys [leaf_count] is scratch
//   launch groups of WORK_GROUP_SIZE; the first three each on piece_length codes, recode_runs each on some of the runs
// recode_at_once does all that with one group, for few codes, whose launches would cost more than their work; it clears
// the state itself.
//   local  64 * WORK_GROUP_SIZE bytes
// A round but the first does something where the one before has packed codes; find_levels and pack_codes where runs
// are too long for the low bits.
//
// state [RECODE_STATE_WORDS a round] is what clear_state, one group, leaves before. index_bits: of the first round's
// codes, the low ones that are no code.
#include "work_group.clh"
#include "aabb.clh"
#include "scan.clh"
#include "input.clh"
#include "scene_bounds.clh"
#include "bits.clh"
#include "morton.clh"
#include "morton_grid.clh"
#include "small_sort.clh"

#define RUN_COUNT 0
#define LONGEST 1
#define LEVELS_LOW 2
#define LEVELS_HIGH 3

static inline uint bits_of_count(uint count) {
    return count > 1 ? 32 - clz(count - 1) : 0;
}

static inline ulong low_bits(uint count) {
    return count == 0 ? 0 : ~0ul >> (64 - count);
}

// Packing pays where the bits of a run's positions leave too few for codes among the low ones: some eight cells for
// each primitive of it.
static inline uint is_too_long(uint longest, uint tie_bits) {
    return longest > 0 && 2 * bits_of_count(longest) + 3 > tie_bits;
}

// How a round finds the keys.
typedef struct {
    uint is_active;
    uint tie_bits;  // low bits that are no code
} Round;

// Reads the state of the rounds before alone: that of the round itself changes while runs are found.
static inline void find_round(global const uint* state, uint round, uint index_bits, Round* now) {
    now->is_active = 1;
    now->tie_bits = index_bits;
    for (uint k = 0; k < round; ++k) {
        const uint longest = state[RECODE_STATE_WORDS * k + LONGEST];
        now->is_active = now->is_active && is_too_long(longest, now->tie_bits);
        now->tie_bits = bits_of_count(longest);
    }
}

// Whether keys are packed in the round, whose runs have been found.
static inline uint packs_codes(global const uint* state, uint round, Round now) {
    return now.is_active && is_too_long(state[RECODE_STATE_WORDS * round + LONGEST], now.tie_bits);
}

static inline uint is_same_code(global const ulong* codes, size_t i, size_t k, uint tie_bits) {
    return (codes[i] ^ codes[k]) >> tie_bits == 0;
}

// Codes from `first` on that equal it; at least LONGEST_RUN + 1 do.
static inline uint run_length(global const ulong* codes, size_t first, uint leaf_count, uint tie_bits) {
    size_t last = first + LONGEST_RUN;
    size_t step = LONGEST_RUN;
    while (last + step < leaf_count && is_same_code(codes, first, last + step, tie_bits)) {
        last += step;
        step *= 2;
    }
    for (; step > 0; step /= 2) {
        if (last + step < leaf_count && is_same_code(codes, first, last + step, tie_bits)) {
            last += step;
        }
    }
    return (uint)(last - first) + 1;
}

// Codes, and which of them the work group takes.
typedef struct {
    uint leaf_count;
    size_t begin, end;
} Piece;

#define PIECE_OF_GROUP(piece)                                            \
    const size_t piece##_begin = get_group_id(0) * (size_t)piece_length; \
    const Piece piece = {*leaf_count, piece##_begin, min(piece##_begin + piece_length, (size_t)*leaf_count)};

static inline void add_run(global const ulong* codes, size_t i, uint leaf_count, uint tie_bits, global uint* state,
                           global uint* runs) {
    const uint length = run_length(codes, i, leaf_count, tie_bits);
    const uint run = atomic_inc(state + RUN_COUNT);
    runs[2 * run] = (uint)i;
    runs[2 * run + 1] = length;
    atomic_max(state + LONGEST, length);
}

static inline void find_runs_of_piece(global const ulong* codes, Piece piece, uint index_bits, uint round,
                                      global uint* state, global uint* runs) {
    Round now;
    find_round(state, round, index_bits, &now);
    if (!now.is_active || piece.leaf_count <= LONGEST_RUN) {
        return;
    }
    const size_t last = min(piece.end, (size_t)(piece.leaf_count - LONGEST_RUN));
    FOR_WORK_ITEMS(i, piece.begin, last) {
        if (is_same_code(codes, i, i + LONGEST_RUN, now.tie_bits) &&
            (i == 0 || !is_same_code(codes, i - 1, i, now.tie_bits))) {
            add_run(codes, i, piece.leaf_count, now.tie_bits, state + RECODE_STATE_WORDS * round, runs);
        }
    }
}

static inline void find_levels_of_piece(global const ulong* codes, Piece piece, uint index_bits, uint round,
                                        global uint* state) {
    Round now;
    find_round(state, round, index_bits, &now);
    if (!packs_codes(state, round, now)) {
        return;
    }
    ulong levels = 0;
    FOR_WORK_ITEMS(i, max(piece.begin, (size_t)1), piece.end) {
        const ulong differing = (codes[i - 1] ^ codes[i]) >> now.tie_bits;
        levels |= differing == 0 ? 0 : 1ul << (63 - clz(differing));
    }
    atomic_or(state + RECODE_STATE_WORDS * round + LEVELS_LOW, (uint)levels);
    atomic_or(state + RECODE_STATE_WORDS * round + LEVELS_HIGH, (uint)(levels >> 32));
}

static inline ulong levels_of(global const uint* state, uint round) {
    global const uint* const own = state + RECODE_STATE_WORDS * round;
    return (ulong)own[LEVELS_HIGH] << 32 | own[LEVELS_LOW];
}

// Bits of packed keys that are not the packed code's.
static inline uint free_bits(ulong levels) {
    return min(64 - (uint)popcount(levels), 63u);
}

// The bits of `code` that `levels` has, side by side: a field of neighbouring ones at a time.
static inline ulong pick_bits(ulong code, ulong levels) {
    ulong picked = 0;
    uint at = 0;
    while (levels != 0) {
        const uint skipped = 63 - (uint)clz(levels & -levels);
        levels >>= skipped;
        code >>= skipped;
        const ulong above = ~levels;
        const uint width = above == 0 ? 64 : 63 - (uint)clz(above & -above);
        picked |= (code & low_bits(width)) << at;
        at += width;
        levels = width < 64 ? levels >> width : 0;
        code = width < 64 ? code >> width : 0;
    }
    return picked;
}

static inline void pack_codes_of_piece(global ulong* codes, Piece piece, uint index_bits, uint round,
                                       global const uint* state) {
    Round now;
    find_round(state, round, index_bits, &now);
    if (!packs_codes(state, round, now)) {
        return;
    }
    const ulong levels = levels_of(state, round);
    const uint shift = free_bits(levels);
    FOR_WORK_ITEMS(i, piece.begin, piece.end) {
        codes[i] = pick_bits(codes[i] >> now.tie_bits, levels) << shift | (codes[i] & low_bits(now.tie_bits));
    }
}

// Sorts keys [length] by the bits above tie_bits; `codes` is scratch. The low bits name the order before, in which ids
// are sorted along.
static inline void sort_run(global ulong* keys, global ulong* codes, global uint* ids, uint length, uint tie_bits,
                            uint code_bits, ulong prefix) {
    global ulong* const sorted = sort_keys(keys, codes, length, tie_bits, code_bits);
    global uint* const old_ids = (global uint*)(sorted == keys ? codes : keys);
    GLOBAL_BARRIER();
    FOR_WORK_ITEMS(i, 0, length) {
        old_ids[i] = ids[i];
    }
    GLOBAL_BARRIER();
    FOR_WORK_ITEMS(i, 0, length) {
        ids[i] = old_ids[sorted[i] & low_bits(tie_bits)];
    }
    GLOBAL_BARRIER();
    FOR_WORK_ITEMS(i, 0, length) {
        codes[i] = prefix | (sorted[i] & ~low_bits(tie_bits)) | i;
    }
    GLOBAL_BARRIER();
}

// What is sorted, by run.
typedef struct {
    global const float* boxes;
    global ulong* codes;
    global uint* ids;
    global ulong* keys;
} RunArrays;

static inline void recode_runs_of_group(RunArrays all, uint index_bits, uint round, global const uint* state,
                                        global const uint* runs, local SceneBounds* scratch) {
    Round now;
    find_round(state, round, index_bits, &now);
    if (!now.is_active) {
        return;
    }
    global const uint* const own = state + RECODE_STATE_WORDS * round;
    const uint run_count = own[RUN_COUNT];
    const uint is_packed = packs_codes(state, round, now);
    const uint available = is_packed ? free_bits(levels_of(state, round)) : now.tie_bits;
    for (uint run = (uint)get_group_id(0); run < run_count; run += (uint)get_num_groups(0)) {
        const size_t begin = runs[2 * run];
        const uint length = runs[2 * run + 1];
        global ulong* const codes = all.codes + begin;
        global uint* const ids = all.ids + begin;
        global ulong* const keys = all.keys + begin;
        const uint tie_bits = bits_of_count(is_packed ? own[LONGEST] : length);
        const uint code_bits = available - tie_bits;
        const ulong prefix = codes[0] & ~low_bits(available);
        SceneBounds bounds = empty_bounds();
        FOR_WORK_ITEMS(i, 0, length) {
            const Box box = load_box(all.boxes + BOX_FLOATS * (size_t)ids[i]);
            const float4 centroid = (float4)(CENTROID_OF(box, x), CENTROID_OF(box, y), CENTROID_OF(box, z), 0.0f);
            bounds.centroid_lower = MIN_OF(bounds.centroid_lower, centroid);
            bounds.centroid_upper = MAX_OF(bounds.centroid_upper, centroid);
        }
        bounds = reduce_over_group(scratch, bounds);
        LOCAL_BARRIER();
        const float4 extent = bounds.centroid_upper - bounds.centroid_lower;
        if (!(extent.x > 0.0f || extent.y > 0.0f || extent.z > 0.0f)) {
            continue;  // They are all in one place.
        }
        MortonGrid grid;
        make_grid(bounds.centroid_lower, bounds.centroid_upper, 1, &grid);
        FOR_WORK_ITEMS(i, 0, length) {
            const ulong code = grid_code(grid, load_box(all.boxes + BOX_FLOATS * (size_t)ids[i]));
            keys[i] = code >> (CODE_BITS - min(code_bits, (uint)CODE_BITS)) << tie_bits | i;
        }
        GLOBAL_BARRIER();
        sort_run(keys, codes, ids, length, tie_bits, code_bits, prefix);
    }
}

static inline void clear_words_of_state(global uint* state) {
    FOR_WORK_ITEMS(k, 0, RECODE_ROUNDS * RECODE_STATE_WORDS) {
        state[k] = 0;
    }
}

KERNEL void clear_state(global uint* state) {
    clear_words_of_state(state);
}

KERNEL void find_runs(global const ulong* codes, global const uint* leaf_count, uint piece_length, uint index_bits,
                      uint round, global uint* state, global uint* runs) {
    PIECE_OF_GROUP(piece)
    find_runs_of_piece(codes, piece, index_bits, round, state, runs);
}

KERNEL void find_levels(global const ulong* codes, global const uint* leaf_count, uint piece_length, uint index_bits,
                        uint round, global uint* state) {
    PIECE_OF_GROUP(piece)
    find_levels_of_piece(codes, piece, index_bits, round, state);
}

KERNEL void pack_codes(global ulong* codes, global const uint* leaf_count, uint piece_length, uint index_bits,
                       uint round, global const uint* state) {
    PIECE_OF_GROUP(piece)
    pack_codes_of_piece(codes, piece, index_bits, round, state);
}

KERNEL void recode_runs(global const float* boxes, uint index_bits, uint round, global const uint* state,
                        global const uint* runs, global ulong* codes, global uint* ids, global ulong* keys) {
    local SceneBounds scratch[WORK_GROUP_SIZE];
    const RunArrays arrays = {boxes, codes, ids, keys};
    recode_runs_of_group(arrays, index_bits, round, state, runs, scratch);
}

KERNEL void recode_at_once(global const float* boxes, global const uint* leaf_count, uint index_bits,
                           global uint* state, global uint* runs, global ulong* codes, global uint* ids,
                           global ulong* keys) {
    local SceneBounds scratch[WORK_GROUP_SIZE];
    const RunArrays arrays = {boxes, codes, ids, keys};
    const Piece piece = {*leaf_count, 0, *leaf_count};
    clear_words_of_state(state);
    GLOBAL_BARRIER();
    for (uint round = 0; round < RECODE_ROUNDS; ++round) {
        find_runs_of_piece(codes, piece, index_bits, round, state, runs);
        GLOBAL_BARRIER();
        find_levels_of_piece(codes, piece, index_bits, round, state);
        GLOBAL_BARRIER();
        pack_codes_of_piece(codes, piece, index_bits, round, state);
        GLOBAL_BARRIER();
        recode_runs_of_group(arrays, index_bits, round, state, runs, scratch);
        GLOBAL_BARRIER();
    }
}
