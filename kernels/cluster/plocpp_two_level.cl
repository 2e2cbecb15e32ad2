// PLOC++ Two-Level: independent Morton ranges, one work group each, then the top (Benthin et al. 2022, section 4.5).
//
// extract_ranges   in codes [leaf_count]  out range_begins [MAX_RANGES + 1], range_total [1]; one group
//                  Every round splits the ranges longer than half the longest one, until there are range_count of them.
// cluster_ranges   clusters each range down to SEARCH_RADIUS; MAX_RANGES groups, one a range, of which the idle end at
//                  once
//                  inout references, other [leaf_count]
//                  out   survivors [MAX_RANGES * SEARCH_RADIUS], survivor_counts [MAX_RANGES]
// finish_ranges    joins the survivors in `references` and clusters them to the root; one group; root_reference [1]
//
// local  as plocpp.cl, and 2 * MAX_RANGES * 4 bytes
#include "work_group.clh"
#include "lanes.clh"
#include "aabb.clh"
#include "node.clh"
#include "scan.clh"
#include "morton_split.clh"
#include "cluster.clh"
#define BORDER (2 * SEARCH_RADIUS)
#include "chunk.clh"
#include "neighbour_search.clh"
#include "merge.clh"
#include "range.clh"

#ifndef MAX_RANGES
#define MAX_RANGES 256
#endif

KERNEL void extract_ranges(global const ulong* codes, global const uint* leaf_count_in, uint range_count,
                           global uint* range_begins, global uint* range_total) {
    const uint leaf_count = *leaf_count_in;
    local uint begins[MAX_RANGES + 1];
    local uint splits[MAX_RANGES];
    local uint total;
    local uint longest;
    if (LOCAL_ID == 0) {
        begins[0] = 0;
        begins[1] = leaf_count;
        total = 1;
        longest = leaf_count;
    }
    LOCAL_BARRIER();
    while (total < range_count && longest > SEARCH_RADIUS) {
        FOR_WORK_ITEMS(k, 0, total) {
            const uint length = begins[k + 1] - begins[k];
            splits[k] =
                2 * length > longest && length > SEARCH_RADIUS ? morton_split(codes, begins[k], begins[k + 1]) : 0;
        }
        LOCAL_BARRIER();
        if (LOCAL_ID == 0) {
            uint added = 0;
            for (uint k = 0; k < total; ++k) {
                added += splits[k] != 0;
            }
            // From the last range to the first, so that each is read before its place is taken.
            uint to = total + added;
            begins[to] = leaf_count;
            longest = 0;
            for (uint k = total; k-- > 0;) {
                const uint begin = begins[k];
                if (splits[k] != 0) {
                    begins[--to] = splits[k];
                    longest = max(longest, begins[to + 1] - begins[to]);
                }
                begins[--to] = begin;
                longest = max(longest, begins[to + 1] - begins[to]);
            }
            total += added;
        }
        LOCAL_BARRIER();
    }
    FOR_WORK_ITEMS(k, 0, total + 1) {
        range_begins[k] = begins[k];
    }
    if (LOCAL_ID == 0) {
        *range_total = total;
    }
}

KERNEL void cluster_ranges(global const uint* range_begins, global const uint* range_total, global uint* references,
                           global uint* other, global const float* leaves, global float* inner, global float* nodes,
                           global const uint* leaf_count_in, global uint* survivors, global uint* survivor_counts) {
    const uint leaf_count = *leaf_count_in;
    DECLARE_CHUNK(chunk);
    DECLARE_SEARCH_SCRATCH(search);
    DECLARE_MERGE(survivor, merging, chunk);
    local uint scan[WORK_GROUP_SIZE];
    const uint range = get_group_id(0);
    const uint begin = range < *range_total ? range_begins[range] : 0;
    const uint end = range < *range_total ? range_begins[range + 1] : 0;
    const uint left = cluster_range(chunk, search, survivor, merging, scan, references + begin, other + begin,
                                    end - begin, SEARCH_RADIUS, leaves, inner, nodes, leaf_count);
    FOR_WORK_ITEMS(k, 0, left) {
        survivors[range * SEARCH_RADIUS + k] = references[begin + k];
    }
    if (LOCAL_ID == 0) {
        survivor_counts[range] = left;
    }
}

KERNEL void finish_ranges(global const uint* survivors, global const uint* survivor_counts, global uint* references,
                          global uint* other, global const float* leaves, global float* inner, global float* nodes,
                          global const uint* leaf_count_in, global uint* root_reference) {
    const uint leaf_count = *leaf_count_in;
    DECLARE_CHUNK(chunk);
    DECLARE_SEARCH_SCRATCH(search);
    DECLARE_MERGE(survivor, merging, chunk);
    local uint scan[WORK_GROUP_SIZE];
    local uint offsets[MAX_RANGES + 1];
    if (LOCAL_ID == 0) {
        uint sum = 0;
        for (uint range = 0; range < MAX_RANGES; ++range) {
            offsets[range] = sum;
            sum += survivor_counts[range];
        }
        offsets[MAX_RANGES] = sum;
    }
    LOCAL_BARRIER();
    FOR_WORK_ITEMS(range, 0, MAX_RANGES) {
        for (uint k = offsets[range]; k < offsets[range + 1]; ++k) {
            references[k] = survivors[range * SEARCH_RADIUS + k - offsets[range]];
        }
    }
    GLOBAL_BARRIER();
    cluster_range(chunk, search, survivor, merging, scan, references, other, offsets[MAX_RANGES], 1, leaves, inner,
                  nodes, leaf_count);
    if (LOCAL_ID == 0) {
        *root_reference = references[0];
    }
}
