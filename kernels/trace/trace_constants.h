// How scenes lie in memory for rays: what kernels, the host and the host's own tracer all know.
#ifndef CLBVH_KERNELS_TRACE_CONSTANTS_H
#define CLBVH_KERNELS_TRACE_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    INPUT_LEAF_ORDER = 5,  // beside the forms of build_constants.h: a traversal layout's rows
    LEAF_ROWS = 3,         // float4 a triangle: x, y and z of its corners; the last word holds its number
};

// A tree of eight children: nodes, and blocks of triangles behind them.
enum {
    WIDE_NODE_FLOATS = 56,  // [lower or upper][axis][child], then the children
    WIDE_UPPER_FLOATS = 24,
    WIDE_CHILDREN = 48,
    WIDE_LEAF_BIT = 31,  // of a child: it is the first block of a leaf
    BLOCK_FLOATS = 40,   // [corner][axis][triangle], then the primitives; NaNs where there are fewer
    BLOCK_TRIANGLES = 4,
    LAST_BLOCK_BIT = 31,  // of a block's first primitive: the leaf has no further block
    WIDE_HEADER_WORDS = 16,
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
