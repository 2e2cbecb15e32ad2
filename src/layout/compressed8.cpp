// Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", in the format
// of tinybvh's BVH8_CWBVH. Here bounds are rounded without error, however far a node is from the origin, and nodes are
// opened by area unless the paper's cheapest opening is asked for.
#include "clbvh/layout/compressed8.hpp"

#include <tbb/parallel_for.h>

#include <limits>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/primitive_access.hpp"
#include "core/simd/prefetch.hpp"
#include "layout/check_tree.hpp"
#include "layout/compressed8_grid.hpp"
#include "layout/compressed8_triangle.hpp"
#include "layout/make_in_arena.hpp"
#include "layout/opening.hpp"

namespace clbvh {
namespace {

using namespace layout;

constexpr std::uint32_t kMaxTriangles = 3;  // of a leaf
using Rules = OpeningRules<8, kMaxTriangles, kMaxTriangles, kMaxTriangles, Slots::by_octant>;

/// The leaves of one piece, in order.
struct PieceLeaves {
    std::vector<std::uint32_t> primitives;  ///< Leaf after leaf.
    std::vector<std::uint32_t> begins;      ///< Of each leaf, in `primitives`; and their end.
    std::uint32_t first_triangle = 0;       ///< Number of the first in the whole.
};

PieceLeaves leaves_of(const Piece<8>& piece, const std::uint32_t* primitive_ids) {
    PieceLeaves leaves;
    leaves.primitives.reserve(kMaxTriangles * piece.blocks.size());
    leaves.begins.reserve(piece.blocks.size() + 1);
    for (const Places& places : piece.blocks) {
        leaves.begins.push_back(static_cast<std::uint32_t>(leaves.primitives.size()));
        for (std::uint32_t i = 0; i < kMaxTriangles && places[i] != kNone; ++i)
            leaves.primitives.push_back(primitive_ids[places[i]]);
    }
    leaves.begins.push_back(static_cast<std::uint32_t>(leaves.primitives.size()));
    return leaves;
}

/// Writes one piece. `Triangles` is one of primitive_access.hpp.
template <typename Triangles>
class PieceWriter {
public:
    PieceWriter(const Node* nodes, const Triangles& triangles, const Piece<8>& piece, const PieceLeaves& leaves)
        : nodes_(nodes), triangles_(triangles), piece_(piece), leaves_(leaves) {}

    void write_nodes(bool is_top, Compressed8Node* target) const {
        constexpr std::size_t kNodesAhead = 6;
        if (!is_top) write_node(piece_.root_node, target[piece_.root]);
        for (std::size_t i = 0; i < piece_.nodes.size(); ++i) {
            if (i + kNodesAhead < piece_.nodes.size()) {
                for (const std::uint32_t ahead : piece_.nodes[i + kNodesAhead].nodes) {
                    if (ahead != kNone) prefetch(nodes_ + ahead);
                }
            }
            write_node(piece_.nodes[i], target[piece_.first_node + i]);
        }
    }

    void write_triangles(Compressed8Triangle* target) const {
        constexpr std::size_t kAhead = 16;
        const std::vector<std::uint32_t>& primitives = leaves_.primitives;
        for (std::size_t i = 0; i < primitives.size(); ++i) {
            if (i + 2 * kAhead < primitives.size()) prefetch(triangles_.indices_of(primitives[i + 2 * kAhead]));
            if (i + kAhead < primitives.size()) {
                for (std::size_t corner = 0; corner < 3; ++corner)
                    prefetch(triangles_.vertex(triangles_.index(primitives[i + kAhead], corner)));
            }
            target[leaves_.first_triangle + i] = make_triangle(triangles_, primitives[i]);
        }
    }

private:
    void write_node(const OpenedNode<8>& opened, Compressed8Node& node) const {
        node.inner_mask = 0;
        node.first_child = 0;
        node.first_triangle = 0;
        node.meta.fill(0);
        std::uint32_t first_place = kNone;  // of the node's triangles among those of the piece
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            const std::uint32_t child = opened.children[slot];
            if (child == kNone) continue;
            if ((child & Rules::kLeaf) == 0) {
                if (node.inner_mask == 0) node.first_child = piece_.first_node + child;
                node.inner_mask = static_cast<std::uint8_t>(node.inner_mask | 1U << slot);
                node.meta[slot] = static_cast<std::uint8_t>(1U << 5U | (24 + slot));
                continue;
            }
            const std::uint32_t leaf = child & ~Rules::kLeaf;
            const std::uint32_t begin = leaves_.begins[leaf], count = leaves_.begins[leaf + 1] - begin;
            if (first_place == kNone) {
                first_place = begin;
                node.first_triangle = 3 * (leaves_.first_triangle + begin);
            }
            node.meta[slot] = static_cast<std::uint8_t>(((1U << count) - 1) << 5U | (begin - first_place));
        }
        write_boxes(opened, node);
    }

    void write_boxes(const OpenedNode<8>& opened, Compressed8Node& node) const {
        std::array<Node, 8> parts;
        std::array<const Node*, 8> boxes;
        for (std::uint32_t slot = 0; slot < 8; ++slot)
            boxes[slot] = opened.nodes[slot] == kNone ? nullptr : source_of(opened, slot, parts[slot]);
        write_grid(boxes, node);
    }

    /// The node of the binary tree whose box a child has; for a part of a large leaf `part`, with the box of what is of
    /// its triangles in there.
    [[nodiscard]] const Node* source_of(const OpenedNode<8>& opened, std::uint32_t slot, Node& part) const {
        const Node& node = nodes_[opened.nodes[slot]];
        const std::uint32_t child = opened.children[slot];
        if (node.count <= kMaxTriangles || (child & Rules::kLeaf) == 0) return &node;
        const std::uint32_t leaf = child & ~Rules::kLeaf;
        const Aabb whole = node.bounds();
        Aabb box;
        for (std::uint32_t i = leaves_.begins[leaf]; i < leaves_.begins[leaf + 1]; ++i)
            box = merge(box, TriangleBoxes{triangles_}.box(leaves_.primitives[i]));
        box = {(max)(box.lower, whole.lower), (min)(box.upper, whole.upper)};
        // A leaf of split triangles may name one of which nothing is in its box.
        if (!(box.lower.x <= box.upper.x && box.lower.y <= box.upper.y && box.lower.z <= box.upper.z)) return &node;
        part = {{box.lower.x, box.lower.y, box.lower.z}, 0, {box.upper.x, box.upper.y, box.upper.z}, 0};
        return &part;
    }

    const Node* nodes_;
    const Triangles& triangles_;
    const Piece<8>& piece_;
    const PieceLeaves& leaves_;
};

/// Gives the pieces' triangles their places. Returns how many there are.
std::uint64_t number_triangles(std::vector<PieceLeaves>& pieces) {
    std::uint64_t count = 0;
    for (PieceLeaves& piece : pieces) {
        piece.first_triangle = static_cast<std::uint32_t>(count);
        count += piece.primitives.size();
    }
    if (3 * count <= std::numeric_limits<std::uint32_t>::max()) return count;
    throw Error(ErrorCode::unsupported, "the layout would have " + std::to_string(count) +
                                            " triangles, whose places do not fit into 32 bits; trace them in parts");
}

/// In the current arena.
void convert(const Bvh& bvh, const MeshView& mesh, Compressed8& result, NodeOpening node_opening) {
    Opening<Rules> opening;
    opening.run(bvh.nodes, node_opening);
    const auto pieces = opening.pieces();
    std::vector<PieceLeaves> leaves(pieces.size());
    const auto for_each_piece = [&](const auto& action) {
        tbb::parallel_for(std::size_t{0}, pieces.size(), action, tbb::simple_partitioner{});
    };
    for_each_piece([&](std::size_t i) { leaves[i] = leaves_of(pieces[i], bvh.primitive_ids.data()); });
    result.triangles.resize_for_overwrite(number_triangles(leaves));
    result.nodes.resize_for_overwrite(opening.node_count());
    with_triangles(mesh, [&](const auto& triangles) {
        for_each_piece([&](std::size_t i) {
            const PieceWriter writer(bvh.nodes.data(), triangles, pieces[i], leaves[i]);
            writer.write_nodes(i == 0, result.nodes.data());
            writer.write_triangles(result.triangles.data());
        });
    });
    result.depth = opening.depth();
}

}  // namespace

void make_layout(const Bvh& bvh, const MeshView& mesh, Compressed8& result, const LayoutOptions& options) {
    make_in_arena(result, options, [&] {
        if (options.check) check_tree(bvh, mesh);
        if (!bvh.empty()) convert(bvh, mesh, result, options.opening);
    });
    result.primitive_count = bvh.primitive_count;
    result.split_references = bvh.split_references;
}

}  // namespace clbvh
