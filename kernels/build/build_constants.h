// Shared by the host and the kernels of a build's stages.
#ifndef CLBVH_KERNELS_BUILD_CONSTANTS_H
#define CLBVH_KERNELS_BUILD_CONSTANTS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

// How primitives lie in memory.
enum {
    INPUT_TIGHT = 0,       // triangles: float[3] a vertex, uint[3] a triangle, nothing between them
    INPUT_INDEXED_32 = 1,  // triangles: strides in bytes, uint indices
    INPUT_INDEXED_16 = 2,  // triangles: strides in bytes, ushort indices
    INPUT_TRIANGLES = 3,   // triangles without indices: three vertices each, one behind the other
    INPUT_BOXES = 4,       // boxes: lower and upper corner, stride in bytes
};

enum {
    BOUNDS_FLOATS = 12,  // of a scene: lower and upper corner of all boxes, then of their centroids
    // Bits of a digit of the sort. A private counter and an open cache line for each digit are what a work item has
    // room for; a work group sorts tiles in local memory instead, of so many elements an item.
    LANE_RADIX_BITS = 11,
    GROUP_RADIX_BITS = 8,
    TILE_ELEMENTS_PER_ITEM = 4,
    // Extended codes: a table of 256 entries for each byte of each of four dimensions, and what quantises these.
    MORTON_TABLE_ULONGS = 4 * 4 * 256,
    MORTON_PARAMETERS = 16,
    // Runs of more equal codes than this are coded again (recode.cl), in so many rounds, each with so many words of
    // state.
    LONGEST_RUN = 32,
    RECODE_ROUNDS = 2,
    RECODE_STATE_WORDS = 4,
};

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
