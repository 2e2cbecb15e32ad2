// PLOC++: two kernels an iteration, and one work group for the top (Benthin et al. 2022, sections 4.1 to 4.4 and 4.7).
// How many clusters there are, the count below, is in device memory (iteration.clh); an iteration that finds no more
// than `threshold` changes nothing.
//
// search_merge   nearest neighbours, merges and the count of valid clusters, in one kernel
//   in     references [count], leaves, inner (cluster.clh)
//   out    marked [count]: references after the merges, INVALID_REFERENCE where a cluster ended
//          inner, nodes: what the merges made; valid_counts [groups]
// compact        removes the invalid ones; each group sums the counts of the groups before it
//   in     marked [count], valid_counts [groups]   out  references, the count after the iteration
//   launch both: the same number of groups, any number
// finish         iterates to the root; one group; writes root_reference [1]; `other` is a second buffer [count]
//
// local  about (9 + 1 or 2) * WORK_GROUP_SIZE * 4 bytes; lane shape: (9 + SEARCH_RADIUS) * CHUNK_STRIDE * 4 + 8 * CHUNK
#include "work_group.clh"
#include "lanes.clh"
#include "aabb.clh"
#include "node.clh"
#include "scan.clh"
#include "cluster.clh"
#define BORDER (2 * SEARCH_RADIUS)
#include "chunk.clh"
#include "neighbour_search.clh"
#include "merge.clh"
#include "iteration.clh"
#include "range.clh"

KERNEL void search_merge(global const uint* references, global const uint* cluster_counts, uint iteration,
                         uint threshold, global const float* leaves, global float* inner, global float* nodes,
                         global const uint* leaf_count_in, global uint* marked, global uint* valid_counts) {
    const uint leaf_count = *leaf_count_in;
    const uint count = count_above(clusters_before(iteration, leaf_count, cluster_counts), threshold);
    DECLARE_CHUNK(chunk);
    DECLARE_SEARCH_SCRATCH(search);
    DECLARE_MERGE(survivor, merging, chunk);
    local uint scan[WORK_GROUP_SIZE];
    const size_t begin = group_begin(count, get_group_id(0));
    const size_t end = group_begin(count, get_group_id(0) + 1);
    uint valid = 0;
    for (size_t chunk_begin = begin; chunk_begin < end; chunk_begin += CHUNK) {
        const uint length = (uint)min((size_t)CHUNK, end - chunk_begin);
        load_chunk(chunk, references, count, (uint)chunk_begin, leaves, inner, leaf_count);
        find_partners(chunk, search, length, (uint)chunk_begin - BORDER);
        merge_chunk(chunk, survivor, merging, length, inner, nodes, leaf_count);
        FOR_WORK_ITEMS(k, 0, length) {
            marked[chunk_begin + k] = survivor[k];
            valid += survivor[k] != INVALID_REFERENCE;
        }
        LOCAL_BARRIER();
    }
    uint total;
    group_exclusive_scan(scan, valid, &total);
    if (LOCAL_ID == 0) {
        valid_counts[get_group_id(0)] = total;
    }
}

KERNEL void compact(global const uint* marked, global uint* cluster_counts, uint iteration, uint threshold,
                    global const uint* leaf_count_in, global const uint* valid_counts, global uint* references) {
    const uint clusters = clusters_before(iteration, *leaf_count_in, cluster_counts);
    const uint count = count_above(clusters, threshold);
    local uint scan[WORK_GROUP_SIZE];
    uint before_me = 0;
    FOR_WORK_ITEMS(g, 0, get_group_id(0)) {
        before_me += valid_counts[g];
    }
    uint kept;
    group_exclusive_scan(scan, before_me, &kept);
    const size_t begin = group_begin(count, get_group_id(0));
    const size_t end = group_begin(count, get_group_id(0) + 1);
#if LANE_SHAPE
    // Written without a branch: what an invalid one leaves behind the last valid one, the next valid one covers; the
    // last store of the piece must not reach into the next group's.
    const uint limit = kept + valid_counts[get_group_id(0)];
    for (size_t i = begin; i < end && kept < limit; ++i) {
        const uint reference = marked[i];
        references[kept] = reference;
        kept += reference != INVALID_REFERENCE;
    }
#else
    for (size_t tile = begin; tile < end; tile += WORK_GROUP_SIZE) {
        const size_t i = tile + LOCAL_ID;
        const uint reference = i < end ? marked[i] : INVALID_REFERENCE;
        uint total;
        const uint at = group_exclusive_scan(scan, reference != INVALID_REFERENCE, &total);
        if (reference != INVALID_REFERENCE) {
            references[kept + at] = reference;
        }
        kept += total;
    }
#endif
    if (LOCAL_ID == 0 && get_group_id(0) == get_num_groups(0) - 1) {
        cluster_counts[iteration % COUNTS_KEPT] = count > 0 ? kept : clusters;
    }
}

KERNEL void finish(global uint* references, global uint* other, global const uint* cluster_counts, uint iteration,
                   global const float* leaves, global float* inner, global float* nodes,
                   global const uint* leaf_count_in, global uint* root_reference) {
    const uint leaf_count = *leaf_count_in;
    const uint count = clusters_before(iteration, leaf_count, cluster_counts);
    DECLARE_CHUNK(chunk);
    DECLARE_SEARCH_SCRATCH(search);
    DECLARE_MERGE(survivor, merging, chunk);
    local uint scan[WORK_GROUP_SIZE];
    cluster_range(chunk, search, survivor, merging, scan, references, other, count, 1, leaves, inner, nodes,
                  leaf_count);
    if (LOCAL_ID == 0) {
        *root_reference = references[0];
    }
}
