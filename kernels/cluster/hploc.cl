// H-PLOC: hierarchical parallel locally-ordered clustering (Benthin, Meister et al. 2024).
#include "work_group.clh"
#include "aabb.clh"
#include "bits.clh"
#include "node.clh"
#include "scan.clh"
#include "morton_split.clh"
#include "cluster_constants.h"
#include "no_cluster.clh"

#ifndef CLUSTER_LIMIT
#define CLUSTER_LIMIT 16
#endif
#ifndef SMALL_RANGE
#define SMALL_RANGE 1
#endif
#ifndef SMALL_LIMIT
#define SMALL_LIMIT 8
#endif
#ifndef MERGE_PAIRS
#define MERGE_PAIRS 1
#endif
#ifndef LEAF_SIZE
#define LEAF_SIZE 1
#endif
// 0: every cluster of a node is measured against every other.
#ifndef SEARCH_RADIUS
#define SEARCH_RADIUS 0
#endif
#ifndef EQUAL_CODES
#define EQUAL_CODES 0
#endif

#if LANE_SHAPE
#include "hploc_lane.clh"
#else
#include "hploc_group.clh"
#endif
#if LEAF_SIZE > 1
#include "hploc_leaves.clh"
#endif
