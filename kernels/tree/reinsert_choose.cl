// Reinsertion: which nodes are worth a search for a better place. Those whose parents are larger than they are by most:
// that difference bounds what a move saves before ancestors shrink.
//
// begin_reinsertion
//   in     nodes [node_count] (tree_nodes.clh)
//   out    locks [2 * node_count], moving [node_count], arrivals [node_count / 2], histogram [RANKS]: zeros; control
//   launch a group for SLOTS_PER_GROUP slots
// rate_nodes
//   in     nodes, parents (parents.cl)
//   out    ranks [node_count]; partial_areas [groups]: of the inner nodes' half areas
//   inout  histogram: nodes of each rank
//   launch any number of groups, each on piece_length pairs
//   local  RANKS * 4 bytes
// begin_passes
//   in     partial_areas [count]   out area [1]: their sum   launch one group
// choose_threshold
//   in     histogram   inout control   launch one group   local RANKS * 4 bytes
// count_candidates
//   in     ranks   out counts [blocks]: above the threshold, and at it; a block is SLOTS_PER_GROUP slots
//   launch a group a block
// scan_candidates
//   inout  counts [blocks]: of all blocks before each   launch one group
// collect_candidates
//   in     ranks, counts   out found: the candidates' slots, ascending; no more than were asked for
//   launch a group a block
#include "work_group.clh"
#include "aabb.clh"
#include "node.clh"
#include "tree_nodes.clh"
#include "scan.clh"
#include "node_area.clh"
#include "reinsert_state.clh"

// Passes begin with so many of the nodes.
#ifndef FIRST_PART
#define FIRST_PART 0.005f
#endif

KERNEL void begin_reinsertion(global const float* nodes, TREE_SIZE_ARGUMENTS, global uint* locks, global uint* moving,
                              global uint* arrivals, global uint* histogram, global uint* control) {
    const size_t begin = get_group_id(0) * (size_t)SLOTS_PER_GROUP;
    FOR_WORK_ITEMS(slot, begin, min(begin + SLOTS_PER_GROUP, (size_t)node_count)) {
        locks[2 * slot] = locks[2 * slot + 1] = 0;
        moving[slot] = 0;
        if (slot % 2 == 0) arrivals[slot / 2] = 0;
    }
    if (get_group_id(0) > 0) return;
    FOR_WORK_ITEMS(rank, 0, RANKS) {
        histogram[rank] = 0;
    }
    if (LOCAL_ID == 0) {
        const uint size = TREE_SIZE;
        const float area = size > 0 ? half_area_of(vload8(0, nodes)) : 0.0f;
        const float scale = (float)(1L << AREA_BITS) / area;
        // Trees of two leaves have nothing to move, and those without a size nothing to gain.
        control[IS_DONE] = !(size > 4 && area > 0.0f && isfinite(area) && isfinite(scale));
        control[PART] = as_uint(FIRST_PART);
        control[SCALE] = as_uint(scale);
    }
}

// Counts a node in, and returns its rank.
static inline ushort rate_node(float parent_area, float8 node, local uint* counts) {
    const ushort rank = rank_of(parent_area - half_area_of(node));
#if LANE_SHAPE
    ++counts[rank];
#else
    atomic_inc(counts + rank);
#endif
    return rank;
}

KERNEL void rate_nodes(global const float* nodes, TREE_SIZE_ARGUMENTS, global const uint* parents, uint piece_length,
                       global const uint* control, global ushort* ranks, global uint* histogram,
                       global Change* partial_areas) {
    local uint counts[RANKS];
    local Change scratch[WORK_GROUP_SIZE];
    const float scale = as_float(control[SCALE]);
    const size_t pairs = control[IS_DONE] ? 0 : TREE_SIZE / 2;
    const size_t begin = get_group_id(0) * (size_t)piece_length;
    FOR_WORK_ITEMS(rank, 0, RANKS) {
        counts[rank] = 0;
    }
    LOCAL_BARRIER();
    Change sum = {0, 0};
    FOR_WORK_ITEMS(pair, begin, min(begin + piece_length, pairs)) {
        const float8 left = vload8(2 * pair, nodes);
        const float8 right = vload8(2 * pair + 1, nodes);
        if (is_inner_node(left)) sum.rise += in_units(half_area_of(left), scale);
        if (is_inner_node(right)) sum.rise += in_units(half_area_of(right), scale);
        // Slots without a node stay, and so do the root and its children.
        const int is_used = FIRST_OF(left) > 0 || COUNT_OF(left) > 0;
        const uint parent = is_used && pair > 0 ? parents[pair] : ROOT_SLOT;
        ranks[2 * pair] = ranks[2 * pair + 1] = 0;
        if (parent != ROOT_SLOT) {
            const float area = half_area_of(vload8(parent, nodes));
            ranks[2 * pair] = rate_node(area, left, counts);
            ranks[2 * pair + 1] = rate_node(area, right, counts);
        }
    }
    LOCAL_BARRIER();
    FOR_WORK_ITEMS(rank, 0, RANKS) {
        if (counts[rank] > 0) atomic_add(histogram + rank, counts[rank]);
    }
    sum = sum_changes(scratch, sum);
    if (LOCAL_ID == 0) partial_areas[get_group_id(0)] = sum;
}

KERNEL void begin_passes(global const Change* partial_areas, uint count, global long* area) {
    local Change scratch[WORK_GROUP_SIZE];
    Change sum = {0, 0};
    FOR_WORK_ITEMS(i, 0, count) {
        sum = add_changes(sum, partial_areas[i]);
    }
    sum = sum_changes(scratch, sum);
    if (LOCAL_ID == 0) *area = sum.rise;
}

KERNEL void choose_threshold(global const uint* histogram, uint most_candidates, global uint* control) {
    local uint counts[RANKS];
    FOR_WORK_ITEMS(rank, 0, RANKS) {
        counts[rank] = histogram[rank];
    }
    LOCAL_BARRIER();
    if (LOCAL_ID > 0) return;
    control[IS_UNDONE] = 0;
    control[CANDIDATES] = 0;
    if (control[IS_DONE]) return;
    uint nodes = 0;
    for (uint rank = 1; rank < RANKS; ++rank)
        nodes += counts[rank];
    const uint part = (uint)(as_float(control[PART]) * (float)nodes);
    const uint wanted = min(max(part, 1u), most_candidates);
    uint above = 0;
    uint rank = RANKS - 1;
    while (rank > 1 && above + counts[rank] < wanted)
        above += counts[rank--];
    const uint quota = min(counts[rank], wanted - above);
    control[THRESHOLD] = rank;
    control[AT_THRESHOLD] = counts[rank];
    control[QUOTA] = quota;
    control[CANDIDATES] = above + quota;
    if (above + quota == 0) control[IS_DONE] = 1;
}

// An item's share of its group's block of slots.
#define ITEM_SLOTS (SLOTS_PER_GROUP / WORK_GROUP_SIZE)
#define FIRST_SLOT(size) min((size_t)(get_group_id(0) * SLOTS_PER_GROUP + LOCAL_ID * ITEM_SLOTS), size)

static inline uint2 count_slots(global const ushort* ranks, size_t begin, size_t end, uint threshold) {
    uint above = 0;
    uint at = 0;
    for (size_t slot = begin; slot < end; ++slot) {
        above += ranks[slot] > threshold;
        at += ranks[slot] == threshold;
    }
    return (uint2)(above, at);
}

KERNEL void count_candidates(global const float* nodes, TREE_SIZE_ARGUMENTS, global const ushort* ranks,
                             global const uint* control, global uint2* counts) {
    local uint scratch[WORK_GROUP_SIZE];
    if (control[IS_DONE]) return;
    const size_t size = TREE_SIZE;
    const size_t begin = FIRST_SLOT(size);
    const uint2 mine = count_slots(ranks, begin, min(begin + ITEM_SLOTS, size), control[THRESHOLD]);
    uint above, at;
    group_exclusive_scan(scratch, mine.x, &above);
    group_exclusive_scan(scratch, mine.y, &at);
    if (LOCAL_ID == 0) counts[get_group_id(0)] = (uint2)(above, at);
}

KERNEL void scan_candidates(uint blocks, global const uint* control, global uint2* counts) {
    local uint scratch[WORK_GROUP_SIZE];
    if (control[IS_DONE]) return;
    uint2 before = (uint2)(0, 0);
    for (uint begin = 0; begin < blocks; begin += WORK_GROUP_SIZE) {
        const uint block = begin + (uint)LOCAL_ID;
        const uint2 mine = block < blocks ? counts[block] : (uint2)(0, 0);
        uint above, at;
        const uint above_before = group_exclusive_scan(scratch, mine.x, &above);
        const uint at_before = group_exclusive_scan(scratch, mine.y, &at);
        if (block < blocks) counts[block] = before + (uint2)(above_before, at_before);
        before += (uint2)(above, at);
    }
}

KERNEL void collect_candidates(global const float* nodes, TREE_SIZE_ARGUMENTS, global const ushort* ranks,
                               global const uint* control, global const uint2* counts, global Found* found) {
    local uint scratch[WORK_GROUP_SIZE];
    if (control[IS_DONE]) return;
    const uint threshold = control[THRESHOLD];
    const ulong quota = control[QUOTA];
    const ulong at_threshold = max(control[AT_THRESHOLD], 1u);
    const size_t size = TREE_SIZE;
    const size_t begin = FIRST_SLOT(size);
    const size_t end = min(begin + ITEM_SLOTS, size);
    const uint2 mine = count_slots(ranks, begin, end, threshold);
    uint total;
    uint above = counts[get_group_id(0)].x + group_exclusive_scan(scratch, mine.x, &total);
    uint at = counts[get_group_id(0)].y + group_exclusive_scan(scratch, mine.y, &total);
    for (size_t slot = begin; slot < end; ++slot) {
        if (ranks[slot] < threshold || threshold == 0) continue;
        // Of those at the threshold one is taken where the quota's share of all up to it is a new number: evenly.
        const uint taken = (uint)(at * quota / at_threshold);
        const int is_above = ranks[slot] > threshold;
        if (is_above || (uint)((at + 1) * quota / at_threshold) > taken) found[above + taken].from = (uint)slot;
        above += is_above;
        at += !is_above;
    }
}
