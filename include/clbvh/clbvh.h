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

/** Kinds of failure: the values of clbvh::ErrorCode, and CLBVH_INTERNAL. */
typedef enum clbvh_error {
    CLBVH_OK = 0,
    CLBVH_INVALID_INPUT = 1,  /**< The caller's data or options are out of their documented range. */
    CLBVH_UNSUPPORTED = 2,    /**< Valid, but this device or build of the library cannot do it. */
    CLBVH_NO_DEVICE = 3,      /**< No OpenCL device, or none that fits. */
    CLBVH_DEVICE_FAILURE = 4, /**< An OpenCL call failed for a reason other than memory. */
    CLBVH_OUT_OF_MEMORY = 5,  /**< Host or device memory is exhausted. */
    CLBVH_IO = 6,             /**< A file could not be read, parsed or written. */
    CLBVH_CANCELLED = 7,      /**< The progress callback asked to stop. */
    CLBVH_INTERNAL = 8        /**< Anything else: a fault of the library, or an exception that a callback threw. */
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

/** A builder, on a device or on the host, with its options, its programs, its memory and the last finished tree. One
    thread at a time. */
typedef struct clbvh_builder clbvh_builder;

/** Creates builder or preset `id` ("plocpp", "high", ...) on the device that `device` picks (null or "": the default,
   see clbvh::pick_device), with default options. Builders of the host ("binned-sah", ...) need no device and ignore
   `device`. `*builder` is null after a failure. */
CLBVH_API clbvh_error clbvh_create_builder(const char* id, const char* device, clbvh_builder** builder);

/** Sets an option for the next clbvh_build: clbvh_set_option(builder, "max_leaf_size", "8"). Each builder reads those
   that concern it. Fails with CLBVH_INVALID_INPUT, naming the option and what it takes, where the value is none of
   that, or there is no such option; the options are then as they were. Options that contradict each other, or ask for
   what the device cannot do, make clbvh_build fail. After a change of value the next clbvh_build loads its programs and
   gets its memory anew; the value that is there changes nothing. */
CLBVH_API clbvh_error clbvh_set_option(clbvh_builder* builder, const char* name, const char* value);

/** The value of an option as clbvh_set_option takes it, valid until the next call with this builder. Null after a
   failure. What a preset puts in the place of defaults is not among it. */
CLBVH_API const char* clbvh_get_option(clbvh_builder* builder, const char* name);

/** Calls `progress`, which may be null, with `user` during the next clbvh_build and those after it. Like an option,
   going from no callback to one or back costs the next clbvh_build its programs and memory; going from one callback to
   another does not. */
CLBVH_API clbvh_error clbvh_set_progress(clbvh_builder* builder, clbvh_progress progress, void* user);

/** The values that an option has. */
typedef enum clbvh_option_type {
    CLBVH_OPTION_WHOLE = 0,   /**< A number of 32 bits without a sign: "16". */
    CLBVH_OPTION_REAL = 1,    /**< "0.3", "1e-05". */
    CLBVH_OPTION_BOOLEAN = 2, /**< "on" or "off". */
    CLBVH_OPTION_CHOICE = 3,  /**< One of the names in `values`. */
    CLBVH_OPTION_TEXT = 4     /**< Any other text. */
} clbvh_option_type;

/** One row of the table of options. The library owns it; later versions may append fields. */
typedef struct clbvh_option {
    const char* name; /**< "max_leaf_size", "ploc.search_radius"; see clbvh::BuildOptions. */
    clbvh_option_type type;
    const char* values;        /**< Its range, for people: "1 to 32". */
    const char* default_value; /**< As clbvh_get_option says it. */
    const char* help;          /**< Its effect, in a sentence. */
    const char* readers;       /**< "all" builders, all "device" builders, or ids with ", " between them. */
} clbvh_option;

/** How many options there are; 0 where the host has no memory left. */
CLBVH_API uint32_t clbvh_option_count(void);
/** The option of that index, below clbvh_option_count; else, and where the host has no memory left, null. */
CLBVH_API const clbvh_option* clbvh_option_info(uint32_t index);

/** Destroys the builder and its tree; null is allowed. */
CLBVH_API void clbvh_destroy_builder(clbvh_builder* builder);

/** Builds over `triangle_count` triangles, three indices each, of `vertex_count` vertices, three floats each, which are
    read where they lie and not needed afterwards. After a failure the builder holds no tree and can be used again. */
CLBVH_API clbvh_error clbvh_build(clbvh_builder* builder, const float* vertices, uint64_t vertex_count,
                                  const uint32_t* triangles, uint64_t triangle_count);

/** The type of one vertex index. */
typedef enum clbvh_index_type { CLBVH_INDEX_UINT32 = 0, CLBVH_INDEX_UINT16 = 1 } clbvh_index_type;

/** Triangles as they lie in the caller's memory; see clbvh::MeshView. Fill with zeros, then set `size` and what there
    is. Later versions may append fields. */
typedef struct clbvh_mesh_view {
    uint32_t size;           /**< sizeof(clbvh_mesh_view) of the caller. */
    uint32_t vertex_stride;  /**< Bytes from one vertex to the next, a multiple of 4, at least 12; 0: 12. */
    const float* vertices;   /**< x y z of the first vertex. */
    uint64_t vertex_count;   /**< Every index is below it. */
    const void* indices;     /**< Three for each triangle; null: triangle i has the vertices 3i, 3i + 1, 3i + 2. */
    uint64_t triangle_count; /**< Triangles. */
    uint32_t index_type;     /**< A clbvh_index_type. */
    uint32_t index_stride;   /**< Bytes from one triangle's first index to the next one's; 0: three indices. */
} clbvh_mesh_view;

/** Boxes as they lie in the caller's memory; see clbvh::BoxView. Fill with zeros, then set `size` and what there is.
    Later versions may append fields. */
typedef struct clbvh_box_view {
    uint32_t size;      /**< sizeof(clbvh_box_view) of the caller. */
    uint32_t stride;    /**< Bytes from one box to the next, a multiple of 4, at least 24; 0: 24. */
    const float* boxes; /**< Lower x y z and upper x y z of the first box. */
    uint64_t count;     /**< Boxes. */
} clbvh_box_view;

/** As clbvh_build, over triangles that lie in any way. */
CLBVH_API clbvh_error clbvh_build_mesh(clbvh_builder* builder, const clbvh_mesh_view* mesh);
/** As clbvh_build, over boxes, for primitives that are not triangles. */
CLBVH_API clbvh_error clbvh_build_boxes(clbvh_builder* builder, const clbvh_box_view* boxes);

/** When clbvh_optimize stops at the latest; fill with zeros, then set `size`. Later versions may append fields. */
typedef struct clbvh_budget {
    uint32_t size;           /**< sizeof(clbvh_budget) of the caller. */
    uint32_t passes;         /**< Most passes over the tree of each optimizer; 0: its own limit. */
    double milliseconds;     /**< No new work is begun after so much time, 0 or more, for each; 0: no limit. */
    clbvh_progress progress; /**< May be null. Returning 0 stops: the tree is then as improved so far. */
    void* progress_user;     /**< Handed to `progress`. */
} clbvh_budget;

/** Statistics of a clbvh_optimize. Set `size`; later versions may append fields. */
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
    the option "optimizers". After a failure the tree is as it was. */
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
/** As clbvh_refit, with triangles that lie in any way. */
CLBVH_API clbvh_error clbvh_refit_mesh(clbvh_builder* builder, const clbvh_mesh_view* mesh, double* sah_before,
                                       double* sah_after);
/** As clbvh_refit, of a tree over boxes. */
CLBVH_API clbvh_error clbvh_refit_boxes(clbvh_builder* builder, const clbvh_box_view* boxes, double* sah_before,
                                        double* sah_after);

/** Proves that the builder's tree is a correct one over the triangles, see clbvh::validate. CLBVH_INVALID_INPUT where
   it is not, and clbvh_last_error says why. */
CLBVH_API clbvh_error clbvh_validate_mesh(const clbvh_builder* builder, const clbvh_mesh_view* mesh);
/** The same for a tree over boxes. */
CLBVH_API clbvh_error clbvh_validate_boxes(const clbvh_builder* builder, const clbvh_box_view* boxes);

/** The tree of the last clbvh_build, valid until the next, or the next clbvh_optimize or clbvh_refit, which change it;
    `*count` becomes its length. Null and 0 where there is none. */
CLBVH_API const clbvh_node* clbvh_nodes(const clbvh_builder* builder, uint64_t* count);
/** The primitive ids that leaves refer to; as clbvh_nodes. Each id of an active triangle once, unless
    clbvh_has_split_references. */
CLBVH_API const uint32_t* clbvh_primitive_ids(const clbvh_builder* builder, uint64_t* count);
/** 1 where the builder was free to cut triangles in parts, else 0. Then an id may repeat, in different leaves, whose
    boxes cover the triangle together, and there may be more ids than triangles. */
CLBVH_API int clbvh_has_split_references(const clbvh_builder* builder);

/** Source text in OpenCL C 1.2 that traces rays through the tree inside kernels of the caller's own; never null, and
    never freed. See clbvh::embed_source and docs/embed.md. */
CLBVH_API const char* clbvh_embed_source(void);

/** The message of this thread's last failed call, valid until its next; "" before the first, never null. At most 4095
    bytes: longer ones are cut. */
CLBVH_API const char* clbvh_last_error(void);

#ifdef __cplusplus
}
#endif

#endif
