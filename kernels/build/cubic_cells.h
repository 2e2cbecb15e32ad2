// How the bits of a Morton code are dealt out to the axes: each halves the cell along the axis on which it is longest,
// so that cells are as cubic as they can be, and no bit is spent on a short axis before the others have come down to
// it. C++ and OpenCL C.
//
//     single  bits of axis a alone, the longest
//     odd     one bit of b, or none
//     pairs   of bits of a and b: a above b where odd, else b above a
//     triples of bits: c above those two
#ifndef CLBVH_KERNELS_CUBIC_CELLS_H
#define CLBVH_KERNELS_CUBIC_CELLS_H
#ifdef __cplusplus
namespace clbvh::kernels {
#endif

enum {
    MOST_AXIS_BITS = 30,  // so that a cell's number is an int
};

typedef struct {
    unsigned int a, b, c;  // the axes, longest first; of equal ones the first
    unsigned int single, odd, pairs, triples;
} CubicCells;

static inline void order_axes(const float* extents, CubicCells* cells) {
    unsigned int a = extents[1] > extents[0] ? 1 : 0;
    a = extents[2] > extents[a] ? 2 : a;
    unsigned int c = extents[1] < extents[2] ? 1 : 2;
    c = extents[0] < extents[c] ? 0 : c;
    cells->a = a;
    cells->b = 3 - a - c;
    cells->c = c;
}

// True where an axis of this extent is halved before the other.
static inline int is_halved_first(float extent, unsigned int axis, float other, unsigned int other_axis) {
    return extent > other || (extent == other && axis < other_axis);
}

// Deals at most `most_bits` bits out over a box with these extents; none is spent on an extent of 0 before others.
static inline void cut_cells(const float* extents, unsigned int most_bits, CubicCells* cells) {
    order_axes(extents, cells);
    float longest = extents[cells->a];
    float middle = extents[cells->b];
    const float shortest = extents[cells->c];
    cells->single = 0;
    while (longest > 0.0f && cells->single < most_bits && cells->single < MOST_AXIS_BITS &&
           is_halved_first(longest, cells->a, middle, cells->b)) {
        longest *= 0.5f;
        ++cells->single;
    }
    // From here on b and a take turns, unless a is still the longest and may have no more.
    unsigned int halvings = 0;
    while (cells->single + halvings < most_bits && middle > 0.0f &&
           (halvings % 2 == 0 ? !is_halved_first(longest, cells->a, middle, cells->b) &&
                                    is_halved_first(middle, cells->b, shortest, cells->c)
                              : cells->single + halvings / 2 < MOST_AXIS_BITS &&
                                    is_halved_first(longest, cells->a, shortest, cells->c))) {
        middle *= halvings % 2 == 0 ? 0.5f : 1.0f;
        longest *= halvings % 2 == 0 ? 1.0f : 0.5f;
        ++halvings;
    }
    cells->odd = halvings % 2;
    cells->pairs = halvings / 2;
    const unsigned int most_triples = (most_bits - cells->single - halvings) / 3;
    const unsigned int bits_left =
        MOST_AXIS_BITS - cells->pairs - (cells->single > cells->odd ? cells->single : cells->odd);
    cells->triples = most_triples < bits_left ? most_triples : bits_left;
}

// The same number of bits for each axis, x above y above z, however long they are.
static inline void stretch_cells(unsigned int axis_bits, CubicCells* cells) {
    cells->a = 2;
    cells->b = 1;
    cells->c = 0;
    cells->single = cells->odd = cells->pairs = 0;
    cells->triples = axis_bits;
}

static inline unsigned int bits_of_cells(const CubicCells* cells) {
    return cells->single + cells->odd + 2 * cells->pairs + 3 * cells->triples;
}

#ifdef __cplusplus
}  // namespace clbvh::kernels
#endif
#endif
