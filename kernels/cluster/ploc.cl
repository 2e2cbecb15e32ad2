// PLOC, the baseline: five kernels an iteration (Meister, Bittner 2018; as described in Benthin et al. 2022, section
// 3).
//
// How many clusters there are, the count below, is in device memory (iteration.clh). An iteration that finds only one
// moves it to the other buffer of references.
//
// search       nearest neighbour of each cluster over [i - SEARCH_RADIUS, i + SEARCH_RADIUS], exact distances
//   in  references [count], leaves, inner (cluster.clh)   out  neighbours [count]: positions
// merge        mutual pairs become inner nodes in place of their first cluster
//   inout references, inner, nodes   in neighbours   out valid [count]: 0 where a cluster ended
// count_valid, scan_valid, compact: the prefix sum over `valid`, in three kernels
//   in references, valid   out compacted, the count after the iteration; root_reference [1]: the first of compacted
//   launch all but scan_valid: the same number of groups, any number
//
// local  about 9 * WORK_GROUP_SIZE * 4 bytes; lane shape: 9 * CHUNK_STRIDE * 4 + CHUNK * 4
#include "work_group.clh"
#include "lanes.clh"
#include "aabb.clh"
#include "node.clh"
#include "scan.clh"
#include "cluster.clh"
#define BORDER SEARCH_RADIUS
#include "chunk.clh"
#include "iteration.clh"

static inline void write_neighbours(Chunk chunk, uint length, uint chunk_begin, global uint* neighbours) {
#if LANE_SHAPE
    for (size_t t = BORDER; t < BORDER + length; t += 16) {
        const Box16 own = chunk_box16(chunk, t);
        const uint16 here = chunk_begin + (uint)t - BORDER + LANES;
        float16 best = INFINITY;
        uint16 best_key = 0xffffffffu;
#pragma unroll
        for (uint r = 1; r <= SEARCH_RADIUS; ++r) {
            LOWER_PAIR16(best, best_key, slot_distance16(own, chunk, t + r), here ^ (here + r))
            LOWER_PAIR16(best, best_key, slot_distance16(own, chunk, t - r), here ^ (here - r))
        }
        vstore16(here ^ best_key, 0, chunk.partner + t);
    }
    FOR_WORK_ITEMS(k, 0, length) {
        neighbours[chunk_begin + k] = chunk.partner[BORDER + k];
    }
#else
    // A distance is not negative, so its bits order as an integer; with the tie's key below them one minimum does both.
    const uint t = get_local_id(0);
    if (t >= BORDER && t < BORDER + length) {
        const uint here = chunk_begin + t - BORDER;
        ulong best = ~0ul;
        for (uint r = 1; r <= SEARCH_RADIUS; ++r) {
            const ulong right = (ulong)as_uint(slot_distance(chunk, t, t + r)) << 32 | (here ^ (here + r));
            const ulong left = (ulong)as_uint(slot_distance(chunk, t, t - r)) << 32 | (here ^ (here - r));
            best = min(best, min(right, left));
        }
        neighbours[here] = here ^ (uint)best;
    }
#endif
}

KERNEL void search(global const uint* references, global const uint* cluster_counts, uint iteration,
                   global const float* leaves, global const float* inner, global const uint* leaf_count_in,
                   global uint* neighbours) {
    const uint leaf_count = *leaf_count_in;
    const uint count = count_above(clusters_before(iteration, leaf_count, cluster_counts), 1);
    DECLARE_CHUNK(chunk);
    const size_t begin = group_begin(count, get_group_id(0));
    const size_t end = group_begin(count, get_group_id(0) + 1);
    for (size_t chunk_begin = begin; chunk_begin < end; chunk_begin += CHUNK) {
        load_chunk(chunk, references, count, (uint)chunk_begin, leaves, inner, leaf_count);
        write_neighbours(chunk, (uint)min((size_t)CHUNK, end - chunk_begin), (uint)chunk_begin, neighbours);
        LOCAL_BARRIER();
    }
}

static inline void merge_pair(uint left, uint right, global uint* references, global const float* leaves,
                              global float* inner, global float* nodes, uint leaf_count) {
    const uint left_reference = references[left];
    const uint right_reference = references[right];
    global const float* left_record = record_of(left_reference, leaves, inner, leaf_count);
    global const float* right_record = record_of(right_reference, leaves, inner, leaf_count);
    const Box left_box = load_box(left_record);
    const Box right_box = load_box(right_record);
    const uint slot = first_position(right_reference, right_record, leaf_count);
    store_inner(inner, slot, merge_boxes(left_box, right_box), first_position(left_reference, left_record, leaf_count));
    write_sibling_pair(nodes, slot, left_box, left_reference, right_box, right_reference, leaf_count);
    references[left] = leaf_count + slot;
}

KERNEL void merge(global uint* references, global const uint* cluster_counts, uint iteration,
                  global const uint* neighbours, global const float* leaves, global float* inner, global float* nodes,
                  global const uint* leaf_count_in, global uchar* valid) {
    const uint leaf_count = *leaf_count_in;
    const uint count = count_above(clusters_before(iteration, leaf_count, cluster_counts), 1);
    const size_t begin = group_begin(count, get_group_id(0));
    const size_t end = group_begin(count, get_group_id(0) + 1);
#if LANE_SHAPE
    // Which clusters merge is hard to predict, so they are listed without a branch first, a chunk at a time; their
    // records are fetched meanwhile.
    local uint merging[CHUNK];
    for (size_t chunk_begin = begin; chunk_begin < end; chunk_begin += CHUNK) {
        const size_t chunk_end = min(chunk_begin + CHUNK, end);
        uint merge_count = 0;
        for (size_t i = chunk_begin; i < chunk_end; ++i) {
            const uint neighbour = neighbours[i];
            const uint mutual = neighbours[neighbour] == i;
            valid[i] = (uchar)(1 - (mutual & (uint)(neighbour < i)));
            merging[merge_count] = (uint)i;
            merge_count += mutual & (uint)(neighbour > i);
        }
        for (size_t m = 0; m < merge_count; ++m) {
            const uint ahead = merging[min(m + 8, (size_t)merge_count - 1)];
            PREFETCH(record_of(references[ahead], leaves, inner, leaf_count));
            PREFETCH(record_of(references[neighbours[ahead]], leaves, inner, leaf_count));
            merge_pair(merging[m], neighbours[merging[m]], references, leaves, inner, nodes, leaf_count);
        }
    }
#else
    FOR_WORK_ITEMS(i, begin, end) {
        const uint neighbour = neighbours[i];
        const int mutual = neighbours[neighbour] == i;
        valid[i] = !(mutual && neighbour < i);
        if (mutual && neighbour > i) {
            merge_pair((uint)i, neighbour, references, leaves, inner, nodes, leaf_count);
        }
    }
#endif
}

KERNEL void count_valid(global const uchar* valid, global const uint* cluster_counts, uint iteration,
                        global const uint* leaf_count_in, global uint* counts) {
    local uint scan[WORK_GROUP_SIZE];
    const uint count = count_above(clusters_before(iteration, *leaf_count_in, cluster_counts), 1);
    const size_t begin = group_begin(count, get_group_id(0));
    const size_t end = group_begin(count, get_group_id(0) + 1);
    uint mine = 0;
    FOR_WORK_ITEMS(i, begin, end) {
        mine += valid[i];
    }
    uint total;
    group_exclusive_scan(scan, mine, &total);
    if (LOCAL_ID == 0) {
        counts[get_group_id(0)] = total;
    }
}

KERNEL void scan_valid(global uint* counts, uint group_count, global uint* cluster_counts, uint iteration,
                       global const uint* leaf_count_in) {
    local uint scan[WORK_GROUP_SIZE];
    const uint clusters = clusters_before(iteration, *leaf_count_in, cluster_counts);
    uint before = 0;
    for (uint tile = 0; tile < group_count; tile += WORK_GROUP_SIZE) {
        const uint g = tile + (uint)LOCAL_ID;
        const uint here = g < group_count ? counts[g] : 0;
        uint total;
        const uint at = group_exclusive_scan(scan, here, &total);
        if (g < group_count) {
            counts[g] = before + at;
        }
        before += total;
    }
    if (LOCAL_ID == 0) {
        cluster_counts[iteration % COUNTS_KEPT] = count_above(clusters, 1) > 0 ? before : clusters;
    }
}

KERNEL void compact(global const uint* references, global const uchar* valid, global const uint* cluster_counts,
                    uint iteration, global const uint* leaf_count_in, global const uint* counts, global uint* compacted,
                    global uint* root_reference) {
    local uint scan[WORK_GROUP_SIZE];
    const uint clusters = clusters_before(iteration, *leaf_count_in, cluster_counts);
    const uint count = count_above(clusters, 1);
    const size_t begin = group_begin(count, get_group_id(0));
    const size_t end = group_begin(count, get_group_id(0) + 1);
    uint kept = counts[get_group_id(0)];
    for (size_t tile = begin; tile < end; tile += WORK_GROUP_SIZE) {
        const size_t i = tile + LOCAL_ID;
        const uint keep = i < end ? valid[i] : 0;
        uint total;
        const uint at = group_exclusive_scan(scan, keep, &total);
        if (keep) {
            compacted[kept + at] = references[i];
        }
        kept += total;
    }
    // The first cluster is never ended by another: it is the first one before and after.
    if (get_global_id(0) == 0 && clusters > 0) {
        compacted[0] = *root_reference = references[0];
    }
}
