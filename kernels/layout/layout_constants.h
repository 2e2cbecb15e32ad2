// How a scene lies in memory for rays, where it is, and how the kernels that make it keep their books: what kernels and
// the host both know. Nodes and blocks are clbvh/layout/wide.hpp's, which is installed without kernels and states them
// again.
#ifndef CLBVH_KERNELS_LAYOUT_CONSTANTS_H
#define CLBVH_KERNELS_LAYOUT_CONSTANTS_H
#ifdef __cplusplus
#include <cstdint>
namespace clbvh::kernels {
using uint = std::uint32_t;
using ulong = std::uint64_t;
#endif

enum {
    MOST_WIDTH = 8,  // children of a node, in any layout
    LEAF_ROWS = 3,   // float4 a triangle: x, y and z of its corners; the last word holds its number
};

// Floats of a wide node of so many children, [lower or upper][axis][child], then the children; and words of a record.
#define WIDE_NODE_FLOATS_OF(width) (7 * (width))
#define RECORD_WORDS_OF(width) (5 * (width) + 4)

#ifndef __cplusplus
// Children of a node.
#ifndef WIDE_WIDTH
#define WIDE_WIDTH 8
#endif

// WideNode<WIDE_WIDTH>.
enum {
    WIDE_NODE_FLOATS = WIDE_NODE_FLOATS_OF(WIDE_WIDTH),
    WIDE_UPPER_FLOATS = 3 * WIDE_WIDTH,
    WIDE_CHILDREN = 6 * WIDE_WIDTH,
};
#endif

// WideChild and TriangleBlock.
enum {
    WIDE_LEAF_BIT = 31,
    WIDE_BLOCK_COUNT_SHIFT = 28,
    WIDE_MOST_BLOCKS = 8,  // of one leaf
    BLOCK_FLOATS = 40,     // [corner][axis][triangle], then the primitives
    BLOCK_PRIMITIVES = 36,
    BLOCK_TRIANGLES = 4,
};

// Compressed8Node and Compressed8Triangle.
enum {
    COMPRESSED_NODE_BYTES = 80,
    COMPRESSED_EXPONENTS = 12,  // bytes
    COMPRESSED_INNER_MASK = 15,
    COMPRESSED_FIRST_CHILD = 4,  // words
    COMPRESSED_FIRST_TRIANGLE = 5,
    COMPRESSED_META = 24,  // bytes
    COMPRESSED_LOWER = 32,
    COMPRESSED_UPPER = 56,
    COMPRESSED_TRIANGLE_FLOATS = 12,  // edges from vertex 0 to 2 and to 1, vertex 0, each with a word behind it
};

// Words of a layout's header.
enum {
    LAYOUT_NODE_COUNT = 0,  // 0 where the tree has no leaves
    LAYOUT_BLOCK_COUNT = 1,
    LAYOUT_DEPTH = 2,
    LAYOUT_TOP = 3,  // of those in depth-first order: pairs in `top`
    LAYOUT_HEADER_WORDS = 16,
};

// Where a tree and its mesh begin in their buffers, in bytes, and how they lie there.
typedef struct {
    ulong nodes, primitive_ids, vertices, indices, active_count;
    uint node_count, has_active_count;               // see tree_nodes.clh
    uint form, vertex_stride, index_stride, unused;  // see input.clh
} ScenePlace;

// Where the parts of a layout begin in its buffer, in bytes. What follows the sources is for those who make it, the
// rows are written last, where the state was. Rays alone go through sources and rows, and so through nodes of eight.
typedef struct {
    ulong header, nodes, blocks, sources, rows, state, pieces, next_chunks, records;
} LayoutPlace;

// The same of a layout whose nodes are in depth-first order; kernels/layout/depth_first.cl says what each part is.
typedef struct {
    ulong header, nodes, primitive_ids, parents, below, places, next_places, top;
} DepthFirstPlace;

enum {
    SUBTREE_WORDS = 3,
    PLACE_WORDS = 3,
    SKIP_NODE_WORDS = 8,   // SkipNode
    PAIR_NODE_WORDS = 16,  // PairNode
};

// The tree is cut as on the host (src/layout/opening.hpp).
enum {
    NODES_OF_PIECE = 2048,
    MOST_PIECES = 1024,                          // that are waited for
    PIECE_SLOTS = MOST_PIECES + MOST_WIDTH + 1,  // the last node may open eight, and the first piece is the top
};

#ifndef __cplusplus
// A node before it is written, in words.
enum {
    RECORD_NODES = 0,                // [child] of the binary tree, whose boxes the children have
    RECORD_KINDS = WIDE_WIDTH,       // four bits a child, KIND_*
    RECORD_CHILD = WIDE_WIDTH + 1,   // number of the first child that is a node, in the piece
    RECORD_BLOCK = WIDE_WIDTH + 2,   // number of the first block, or triangle, in the piece
    RECORD_PLACES = WIDE_WIDTH + 4,  // [child][4]: of one block in primitive_ids, or first and number where more
    RECORD_WORDS = RECORD_WORDS_OF(WIDE_WIDTH),
};
#endif

enum {
    RECORDS_OF_CHUNK = 32,
};

// Four bits of RECORD_KINDS; in between the number of a leaf's blocks or triangles.
enum {
    KIND_NODE = 0,
    KIND_RANGE = 9,  // as a node, over a part of a large leaf
    KIND_NONE = 15,
};

// Words of what is known of a piece, and of the opening as a whole.
enum {
    PIECE_CHUNK = 0,  // the first of its records
    PIECE_NODES = 1,  // its records
    PIECE_BLOCKS = 2,
    PIECE_DEPTH = 3,
    PIECE_ROOT = 4,  // [4] an item: node, depth; where the last is above 0, first and number of places
    PIECE_FIRST_NODE = 8,
    PIECE_FIRST_BLOCK = 9,
    PIECE_WORDS = 16,
    OPENING_PIECES = 0,
    OPENING_TOP = 1,     // nodes of the top, and roots of the other pieces
    OPENING_CHUNKS = 2,  // taken
    OPENING_WORDS = 16,
};

// Added to a row's number, so that processors do not take it for a denormal float, with which they are slow.
#define LEAF_NUMBER_BIT 0x40000000u

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
