#include "trace/wide_tree.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace clbvh::trace {
namespace {

class WideTreeMaker {
public:
    WideTreeMaker(std::span<const Node> nodes, std::span<const LeafTriangle> triangles)
        : nodes_(nodes), triangles_(triangles) {}

    WideTree make() {
        if (nodes_.empty()) return {};
        add_node(0, 1);
        while (!open_.empty()) {
            const Open open = open_.back();
            open_.pop_back();
            const std::uint32_t child =
                is_small(nodes_[open.binary]) ? add_leaf(open.binary) | kLeafFlag : add_node(open.binary, open.depth);
            made_nodes_[open.parent].children[open.slot] = child;
        }
        return {HugePageArray<WideNode>(made_nodes_), HugePageArray<TriangleBlock>(made_blocks_), depth_};
    }

private:
    /// A place in a wide node that the subtree of a binary node will take.
    struct Open {
        std::uint32_t binary;
        std::uint32_t parent, slot;
        std::uint32_t depth;
    };

    /// A binary node that may become a child of a wide one.
    struct Candidate {
        std::uint32_t binary;
        float area;
        bool is_small;
    };
    using Children = std::array<Candidate, kWideChildren>;

    /// Areas that are NaN, as those of boxes that no builder makes, count as 0.
    [[nodiscard]] Candidate candidate(std::uint32_t binary) const {
        const Node& node = nodes_[binary];
        const float area = half_area(node.bounds());
        return {binary, area > 0.0f ? area : 0.0f, is_small(node)};
    }

    /// True where the whole subtree goes into one leaf.
    [[nodiscard]] bool is_small(const Node& node) const {
        return node.is_leaf() || count_up_to(node, kBlockTriangles) <= kBlockTriangles;
    }

    /// The triangles below `node`; where they are more than `most`, some number above `most`.
    [[nodiscard]] std::uint64_t count_up_to(const Node& node, std::uint64_t most) const {
        if (node.is_leaf()) return node.count;
        if (most < 2) return most + 1;  // each child has one at least
        const std::uint64_t first = count_up_to(nodes_[node.first], most - 1);
        return first >= most ? most + 1 : first + count_up_to(nodes_[std::size_t{node.first} + 1], most - first);
    }

    /// Opens the node, then the largest one again and again until there are eight. A root that is small stays alone.
    /// Large children come first: rays that look for any hit try them in this order.
    std::span<const Candidate> children_of(std::uint32_t binary, Children& children) const {
        std::size_t count = 1;
        children[0] = candidate(binary);
        for (auto opened = children.begin(); count < kWideChildren && !opened->is_small;) {
            const std::uint32_t first = nodes_[opened->binary].first;
            *opened = candidate(first);
            children[count++] = candidate(first + 1);
            const auto end = children.begin() + count;
            opened = std::max_element(children.begin(), end, [](const Candidate& a, const Candidate& b) {
                return std::pair(!a.is_small, a.area) < std::pair(!b.is_small, b.area);
            });
        }
        const std::span<Candidate> found = std::span(children).first(count);
        std::ranges::stable_sort(found, std::greater{}, &Candidate::area);
        return found;
    }

    std::uint32_t add_node(std::uint32_t binary, std::uint32_t depth) {
        const auto index = static_cast<std::uint32_t>(made_nodes_.size());
        Children memory;
        const std::span<const Candidate> children = children_of(binary, memory);
        WideNode& node = made_nodes_.emplace_back();
        for (std::uint32_t slot = 0; slot < kWideChildren; ++slot) {
            const Aabb box = slot < children.size() ? nodes_[children[slot].binary].bounds() : Aabb{};
            const std::array<Vec3, 2> corners = {box.lower, box.upper};
            for (std::size_t side = 0; side < 2; ++side) {
                node.bounds[side][0][slot] = corners[side].x;
                node.bounds[side][1][slot] = corners[side].y;
                node.bounds[side][2][slot] = corners[side].z;
            }
            node.children[slot] = kLeafFlag;
        }
        for (auto slot = static_cast<std::uint32_t>(children.size()); slot-- > 0;)
            open_.push_back({children[slot].binary, index, slot, depth + 1});
        depth_ = std::max(depth_, depth);
        return index;
    }

    std::uint32_t add_leaf(std::uint32_t binary) {
        leaf_.clear();
        collect(nodes_[binary]);
        const auto first = static_cast<std::uint32_t>(made_blocks_.size());
        for (std::size_t begin = 0; begin < leaf_.size(); begin += kBlockTriangles) {
            const std::size_t count = std::min<std::size_t>(kBlockTriangles, leaf_.size() - begin);
            add_block(std::span(leaf_).subspan(begin, count));
        }
        made_blocks_.back().primitives[0] |= TriangleBlock::kLastBlockFlag;
        return first;
    }

    void collect(const Node& node) {
        if (node.is_leaf()) {
            for (std::uint32_t i = 0; i < node.count; ++i)
                leaf_.push_back(node.first + i);
            return;
        }
        collect(nodes_[node.first]);
        collect(nodes_[std::size_t{node.first} + 1]);
    }

    void add_block(std::span<const std::uint32_t> slots) {
        constexpr float nan = std::numeric_limits<float>::quiet_NaN();
        TriangleBlock& block = made_blocks_.emplace_back();
        for (std::size_t lane = 0; lane < kBlockTriangles; ++lane) {
            LeafTriangle triangle{{{nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}}, 0};
            if (lane < slots.size()) triangle = triangles_[slots[lane]];
            const std::array<Vec3, 3> vertices = {triangle.vertices.v0, triangle.vertices.v1, triangle.vertices.v2};
            for (std::size_t i = 0; i < 3; ++i) {
                block.vertices[i][0][lane] = vertices[i].x;
                block.vertices[i][1][lane] = vertices[i].y;
                block.vertices[i][2][lane] = vertices[i].z;
            }
            block.primitives[lane] = triangle.primitive;
        }
    }

    std::span<const Node> nodes_;
    std::span<const LeafTriangle> triangles_;
    std::vector<WideNode> made_nodes_;
    std::vector<TriangleBlock> made_blocks_;
    std::uint32_t depth_ = 0;
    std::vector<Open> open_;
    std::vector<std::uint32_t> leaf_;  ///< Places in triangles_ that the leaf at hand is over.
};

}  // namespace

WideTree make_wide_tree(std::span<const Node> nodes, std::span<const LeafTriangle> triangles) {
    return WideTreeMaker(nodes, triangles).make();
}

}  // namespace clbvh::trace
