#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <vector>

#include "clbvh/layout/wide.hpp"
#include "core/tree_walk.hpp"
#include "layout/leaf_check.hpp"

namespace clbvh {
namespace {

using namespace layout;

std::string name_block(std::size_t block) {
    return "block " + std::to_string(block);
}

template <std::uint32_t Width>
Aabb bounds_of(const WideNode<Width>& node, std::uint32_t slot) {
    const auto corner = [&](std::size_t side) {
        return Vec3{node.bounds[side][0][slot], node.bounds[side][1][slot], node.bounds[side][2][slot]};
    };
    return {corner(0), corner(1)};
}

/// Goes over the nodes once, in their order: a node's parent has a lower number.
template <std::uint32_t Width>
class WideCheck {
public:
    WideCheck(const WideLayout<Width>& layout, const MeshView& mesh)
        : layout_(layout),
          mesh_(mesh),
          leaves_(mesh, layout.primitive_count, layout.split_references, true),
          places_(layout.nodes.size()),
          is_used_(layout.blocks.size(), false) {}

    void run() {
        // Nothing has the root's box.
        if (!layout_.empty()) places_[0] = {{kLowest, kHighest}, 1};
        std::uint32_t depth = 0;
        for (std::size_t i = 0; i < layout_.nodes.size(); ++i) {
            if (places_[i].depth == 0) reject_layout(name_node(i) + " is not part of the tree");
            depth = std::max(depth, places_[i].depth);
            enter(i);
        }
        reject_unused(is_used_, "block");
        check_depth(layout_.depth, depth);
        leaves_.finish();
    }

private:
    static constexpr Vec3 kLowest{kNegativeInfinity, kNegativeInfinity, kNegativeInfinity};
    static constexpr Vec3 kHighest{kPositiveInfinity, kPositiveInfinity, kPositiveInfinity};

    /// What a node's parent says of it.
    struct Place {
        Aabb box;
        std::uint32_t depth = 0;  ///< That of the root is 1; 0 where no parent was met.
    };

    void enter(std::size_t i) {
        const WideNode<Width>& node = layout_.nodes[i];
        const auto end =
            static_cast<std::uint32_t>(std::ranges::find(node.children, WideChild::kNone) - node.children.begin());
        if (end == 0) reject_layout(name_node(i) + ": it has no child");
        std::size_t next = 0;  // number of the next child that is a node, where there was one
        for (std::uint32_t slot = 0; slot < end; ++slot) {
            const std::uint32_t child = node.children[slot];
            if (!contains(places_[i].box, bounds_of(node, slot)))
                reject_slot(i, slot, "its box is not within that which the parent has for the node");
            if (WideChild::is_leaf(child)) {
                enter_leaf(i, slot);
            } else {
                if (next != 0 && child != next)
                    reject_slot(i, slot, "node " + std::to_string(child) + " is not behind the child before it");
                next = std::size_t{child} + 1;
                enter_child(i, slot);
            }
        }
        for (std::uint32_t slot = end; slot < Width; ++slot)
            if (node.children[slot] != WideChild::kNone) reject_slot(i, slot, "it is behind one that is none");
        for (std::uint32_t slot = end; slot < Width; ++slot) {
            if (bounds_of(node, slot) != Aabb{kHighest, kLowest})
                reject_slot(i, slot, "it has no child, but a box other than from infinity to minus infinity");
        }
    }

    void enter_child(std::size_t i, std::uint32_t slot) {
        const std::size_t child = layout_.nodes[i].children[slot];
        if (child >= layout_.nodes.size()) {
            reject_slot(i, slot,
                        "node " + std::to_string(child) + " is out of range (there are " +
                            std::to_string(layout_.nodes.size()) + ")");
        }
        if (child <= i) reject_slot(i, slot, "node " + std::to_string(child) + " has no higher number than its parent");
        if (places_[child].depth != 0) reject_slot(i, slot, "node " + std::to_string(child) + " has another parent");
        places_[child] = {bounds_of(layout_.nodes[i], slot), places_[i].depth + 1};
    }

    void enter_leaf(std::size_t i, std::uint32_t slot) {
        const std::uint32_t leaf = layout_.nodes[i].children[slot];
        const std::size_t first = WideChild::first_block(leaf), count = WideChild::block_count(leaf);
        if (first + count > layout_.blocks.size()) {
            reject_slot(i, slot,
                        "its " + std::to_string(count) + " blocks from " + std::to_string(first) +
                            " on are out of range (there are " + std::to_string(layout_.blocks.size()) + ")");
        }
        std::array<std::uint32_t, std::size_t{WideChild::kMaxBlocks} * kBlockTriangles> ids;
        std::size_t id_count = 0;
        for (std::size_t block = first; block < first + count; ++block) {
            if (is_used_[block]) reject_slot(i, slot, name_block(block) + " is in another leaf");
            is_used_[block] = true;
            for (const std::uint32_t id : layout_.blocks[block].primitives)
                if (id != kNoPrimitive) ids[id_count++] = id;
        }
        leaves_.add(i, bounds_of(layout_.nodes[i], slot), std::span(ids).first(id_count), slot);
        for (std::size_t block = first; block < first + count; ++block)
            check_block(block);
    }

    /// Its primitives have to be in range: leaves_ has looked at that.
    void check_block(std::size_t index) const {
        const TriangleBlock& block = layout_.blocks[index];
        if (block.primitives[0] == kNoPrimitive) reject_layout(name_block(index) + ": it has no triangle");
        for (std::size_t lane = 0; lane < kBlockTriangles; ++lane) {
            const std::uint32_t primitive = block.primitives[lane];
            if (primitive == kNoPrimitive) {
                check_absent(index, lane);
            } else if (block.primitives[lane - (lane > 0 ? 1 : 0)] == kNoPrimitive) {
                reject_layout(name_block(index) + ": triangle " + std::to_string(lane) + " is behind one that is none");
            } else if (!has_vertices_of(block, lane, primitive)) {
                reject_layout(name_block(index) + ": triangle " + std::to_string(lane) +
                              " has other vertices than primitive " + std::to_string(primitive));
            }
        }
    }

    void check_absent(std::size_t index, std::size_t lane) const {
        for (const auto& corner : layout_.blocks[index].vertices) {
            for (const auto& row : corner) {
                if (row[lane] != row[lane]) continue;
                reject_layout(name_block(index) + ": triangle " + std::to_string(lane) +
                              " is none, but has a vertex other than NaN");
            }
        }
    }

    [[nodiscard]] bool has_vertices_of(const TriangleBlock& block, std::size_t lane, std::uint32_t primitive) const {
        const auto indices = mesh_.triangle(primitive);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3 vertex = mesh_.vertex(indices[corner]);
            const std::array<float, 3> expected = {vertex.x, vertex.y, vertex.z};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (std::bit_cast<std::uint32_t>(block.vertices[corner][axis][lane]) !=
                    std::bit_cast<std::uint32_t>(expected[axis]))
                    return false;
            }
        }
        return true;
    }

    [[noreturn]] static void reject_slot(std::size_t node, std::uint32_t slot, const std::string& fault) {
        reject_layout(name_node(node) + ", child " + std::to_string(slot) + ": " + fault);
    }

    const WideLayout<Width>& layout_;
    MeshView mesh_;
    LeafCheck leaves_;
    std::vector<Place> places_;  ///< One per node.
    std::vector<bool> is_used_;  ///< One per block.
};

}  // namespace

void validate(const Wide8& layout, const MeshView& mesh) {
    WideCheck(layout, mesh).run();
}

void validate(const Wide4& layout, const MeshView& mesh) {
    WideCheck(layout, mesh).run();
}

}  // namespace clbvh
