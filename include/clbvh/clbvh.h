#ifndef CLBVH_CLBVH_H
#define CLBVH_CLBVH_H

/* The C interface of libclbvh: build a tree over a triangle mesh, improve it, let it follow a mesh that moves, read
   it, know why not. */

#include <stdint.h>

#include "clbvh/export.h"
#include "clbvh/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What went wrong; the values of clbvh::ErrorCode. */
typedef enum clbvh_error {
    CLBVH_OK = 0,
    CLBVH_INVALID_INPUT = 1,  /**< The caller's data or options are out of their documented range. */
    CLBVH_UNSUPPORTED = 2,    /**< Valid, but this device or build of the library cannot do it. */
    CLBVH_NO_DEVICE = 3,      /**< No OpenCL device, or none that fits. */
    CLBVH_DEVICE_FAILURE = 4, /**< An OpenCL call failed for a reason other than memory. */
    CLBVH_OUT_OF_MEMORY = 5,  /**< Host or device memory is exhausted. */
    CLBVH_IO = 6,             /**< A file could not be read, parsed or written. */
    CLBVH_CANCELLED = 7       /**< The progress callback asked to stop. */
} clbvh_error;

/** One node, 32 bytes; see clbvh::Node. count == 0: inner, children first and first + 1; else a leaf over
    primitive ids [first, first + count). */
typedef struct clbvh_node {
    float lower[3];
    uint32_t first;
    float upper[3];
    uint32_t count;
} clbvh_node;

/** Called on the building thread between launches, and on the host while a stage is at work, with the stage's name and
   the estimated part done, 0 to 1. Returning 0 cancels. */
typedef int (*clbvh_progress)(void* user, const char* stage, double fraction);

/** Options of a builder; fill with clbvh_default_options first. Later versions may append fields: `size` says which the
    caller knows, the others keep their defaults. */
typedef struct clbvh_options {
    uint32_t size;                   /**< sizeof(clbvh_options) of the caller. */
    uint32_t search_radius;          /**< 1 to 32. */
    uint32_t shape;                  /**< 0 automatic, 1 group, 2 lane. */
    uint32_t extended_morton_code;   /**< 0 3D codes, 1 4D extended codes. */
    uint32_t exact_distances;        /**< 0 the 32-bit encoding of PLOC++, 1 exact. */
    uint32_t single_group_threshold; /**< plocpp: clusters below which one work group finishes, 2 to 2^20; 0: chosen. */
    clbvh_progress progress;         /**< May be null. */
    void* progress_user;             /**< Handed to `progress`. */
    float inner_cost;                /**< Cost of visiting an inner node, above 0: SAH builders, merging of leaves. */
    float primitive_cost;            /**< Cost of testing one primitive, above 0: the same. */
    uint32_t max_leaf_size;          /**< Most primitives of a leaf, 1 to 64; 0: as the builder leaves it. */
    uint32_t presplit_level;         /**< Split triangles with bad edges first, 1 to 40, say 14; 0: do not. */
    uint32_t thread_count;           /**< Threads of the host's work, 1 to 1024; 0: all. */
    uint32_t bin_count;              /**< binned-sah, sbvh: bins an axis, 2 to 64. */
    float split_alpha;               /**< sbvh: see clbvh::BuildOptions, 0 to 1. */
    float reference_budget;          /**< sbvh: most references, as a multiple of the primitives, 1 to 8. */
    uint32_t hploc_quality;          /**< 0 the preset balanced of hploc, 1 fast; see clbvh::HplocQuality. */
    uint32_t code_bits;              /**< Bits of the spatial code that are sorted: 33, 44, 63; 0: chosen. */
    const char* optimizers;          /**< Ids with commas between them, run behind the builder: "reinsert" say, also
                                        those that split triangles first. Null or "": none. Copied. */
    float split_quota;               /**< Split triangles with the largest boxes first, so many times a triangle in all,
                                        above 0 to 4, say 0.3; 0: do not. Not with presplit_level. */
    uint32_t optimize_passes;        /**< Most passes of each optimizer; 0: as many as it finds worth while. */
} clbvh_options;

/** A builder, on a device or on the host, with its programs, its memory and the last finished tree. One thread at a
    time. */
typedef struct clbvh_builder clbvh_builder;

/** Fills the first `size` bytes of `options` with the defaults, and its field `size`. Pass sizeof(clbvh_options): a
   later version of the library then writes no field that the caller was not compiled with. */
CLBVH_API void clbvh_default_options(clbvh_options* options, uint32_t size);

/** Creates builder or preset `id` ("plocpp", "high", ...) on the device that `device` picks (null or "": the default,
   see clbvh::pick_device). Builders of the host ("binned-sah", ...) need no device and ignore `device`. `options` may
   be null. `*builder` is null after a failure. */
CLBVH_API clbvh_error clbvh_create_builder(const char* id, const char* device, const clbvh_options* options,
                                           clbvh_builder** builder);

/** Destroys the builder and its tree; null is allowed. */
CLBVH_API void clbvh_destroy_builder(clbvh_builder* builder);

/** Builds over `triangle_count` triangles, three indices each, of `vertex_count` vertices, three floats each. After a
    failure the builder holds no tree and can be used again. */
CLBVH_API clbvh_error clbvh_build(clbvh_builder* builder, const float* vertices, uint64_t vertex_count,
                                  const uint32_t* triangles, uint64_t triangle_count);

/** When clbvh_optimize stops at the latest; fill with zeros, then set `size`. Later versions may append fields. */
typedef struct clbvh_budget {
    uint32_t size;           /**< sizeof(clbvh_budget) of the caller. */
    uint32_t passes;         /**< Most passes over the tree of each optimizer; 0: its own limit. */
    double milliseconds;     /**< No new work is begun after so much time, for each; 0: no limit. */
    clbvh_progress progress; /**< May be null. Returning 0 stops: the tree is then as improved so far. */
    void* progress_user;     /**< Handed to `progress`. */
} clbvh_budget;

/** What clbvh_optimize did. Set `size`; later versions may append fields. */
typedef struct clbvh_optimize_stats {
    uint32_t size;         /**< sizeof(clbvh_optimize_stats) of the caller. */
    uint32_t passes;       /**< Passes that were finished. */
    uint64_t changes;      /**< Changes that lowered the cost. */
    double milliseconds;   /**< Wall time. */
    double sah_before;     /**< SAH cost of the tree as it was, as clbvh::sah_cost with its default costs. */
    double sah_after;      /**< The same of the tree as it is. */
    uint32_t is_cancelled; /**< 1 where the progress callback asked to stop, else 0. */
    uint32_t unused;       /**< 0. */
} clbvh_optimize_stats;

/** Improves the tree of the last clbvh_build with the optimizers of `ids`, ids with commas between them ("reinsert"
    say; see clbvh::optimizers), one after the other, on all threads. `budget` and `stats` may be null. Fails with
    CLBVH_INVALID_INPUT where there is no tree, an id is unknown, or one splits triangles first: that is for
    clbvh_options.optimizers. After a failure the tree is as it was. */
CLBVH_API clbvh_error clbvh_optimize(clbvh_builder* builder, const char* ids, const clbvh_budget* budget,
                                     clbvh_optimize_stats* stats);

/** Gives the tree of the last clbvh_build the boxes that its triangles ask for at new places, on all threads; its
    structure stays. Arguments as for clbvh_build: as many triangles, of which the same have a NaN. The SAH costs before
    and after go to `sah_before` and `sah_after`, either of which may be null: where the cost has risen much since the
    build, build anew. The second call and later ones are faster. After CLBVH_INVALID_INPUT the tree is as it was. After
    CLBVH_OUT_OF_MEMORY some boxes are old and some new: the next call that succeeds puts all of them right. */
CLBVH_API clbvh_error clbvh_refit(clbvh_builder* builder, const float* vertices, uint64_t vertex_count,
                                  const uint32_t* triangles, uint64_t triangle_count, double* sah_before,
                                  double* sah_after);

/** The tree of the last clbvh_build, valid until the next, or the next clbvh_optimize or clbvh_refit, which change it;
    `*count` becomes its length. Null and 0 where there is none. */
CLBVH_API const clbvh_node* clbvh_nodes(const clbvh_builder* builder, uint64_t* count);
/** The primitive ids that leaves refer to; as clbvh_nodes. Each id of an active triangle once, unless
    clbvh_has_split_references. */
CLBVH_API const uint32_t* clbvh_primitive_ids(const clbvh_builder* builder, uint64_t* count);
/** 1 where the builder was free to cut triangles in parts, else 0. Then an id may repeat, in different leaves, whose
    boxes cover the triangle together, and there may be more ids than triangles. */
CLBVH_API int clbvh_has_split_references(const clbvh_builder* builder);

/** What the last failed call of this thread says; never null. */
CLBVH_API const char* clbvh_last_error(void);

#ifdef __cplusplus
}
#endif

#endif
