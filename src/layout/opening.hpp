#pragma once

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/layout/make_layout.hpp"
#include "core/simd/float4.hpp"
#include "core/simd/prefetch.hpp"
#include "layout/lanes.hpp"
#include "layout/least_cost_opening.hpp"
#include "layout/octant_slots.hpp"
#include "layout/opening_rules.hpp"

// How nodes of two children become nodes of many: which nodes of the binary tree are the children of each wide node,
// and which primitives share a leaf. What is written of that is each layout's own.
namespace clbvh::layout {

/// A wide node before it is written.
template <std::uint32_t Width>
struct OpenedNode {
    std::array<std::uint32_t, Width> nodes;  ///< Of the binary tree, whose boxes the children have; kNone: no child.
    std::array<std::uint32_t, Width>
        children;  ///< A node's number in its piece; kLeaf, blocks and first block of a leaf.
};

/// A part of the wide tree that one task has opened.
template <std::uint32_t Width>
struct Piece {
    std::uint32_t root = 0;  ///< Number of its root in the first piece, where it is written.
    OpenedNode<Width> root_node;
    std::vector<OpenedNode<Width>> nodes;  ///< Those below its root.
    std::vector<Places> blocks;
    std::uint32_t depth = 0;       ///< Of the deepest node; that of the tree's root is 1.
    std::uint32_t first_node = 0;  ///< Number of nodes[0] in the whole.
    std::uint32_t first_block = 0;
};

/// Opens nodes one by one.
template <typename Rules>
class Opener {
public:
    static constexpr std::uint32_t Width = Rules::Width;

    /// What becomes a wide node: a node of the binary tree, or, where count is above 0, places of a large leaf.
    struct Item {
        std::uint32_t node;
        std::uint32_t depth;
        std::uint32_t first, count;
    };

    /// Without a plan nodes are opened largest first.
    Opener(const Node* nodes, Piece<Width>& piece, const LeastCostOpening<Rules>* plan)
        : nodes_(nodes), piece_(piece), plan_(plan) {}

    /// Opens `item`, and puts each child that becomes a node behind the others in `queue`. `next_number` is the next of
    /// these.
    void open(const Item& item, OpenedNode<Width>& opened, std::uint32_t& next_number, std::vector<Item>& queue) {
        piece_.depth = std::max(piece_.depth, item.depth);
        const std::uint32_t count = item.count > 0 ? divide_range(item) : open_node(item.node);
        const std::array<std::uint8_t, Width> order = children_in_slots(count);
        opened.nodes.fill(kNone);
        opened.children.fill(kNone);
        for (std::uint32_t slot = 0; slot < (Rules::kHasGaps ? Width : count); ++slot) {
            const std::uint32_t child = order[slot];
            if (Rules::kHasGaps && child == kNoChild) continue;
            opened.nodes[slot] = node_[child];
            if (kind_[child] == Kind::inner || kind_[child] == Kind::large_leaf) {
                const bool is_range = kind_[child] == Kind::large_leaf;
                opened.children[slot] = next_number++;
                queue.push_back(
                    {node_[child], item.depth + 1, is_range ? first_[child] : 0, is_range ? count_[child] : 0});
            } else {
                opened.children[slot] = add_leaf(child);
            }
        }
    }

    /// Asks for what opening `item` will look at, one level below what was asked for when it was put into the queue.
    void prefetch_for(const Item& item) const {
        if (item.count > 0) return;
        const std::uint32_t first = nodes_[item.node].first;
        for (std::uint32_t k = 0; k < 2; ++k) {
            if (!nodes_[first + k].is_leaf()) prefetch_below_pair(nodes_[first + k].first);
        }
    }

private:
    enum class Kind : std::uint8_t {
        inner,       ///< A node that can be opened.
        large_leaf,  ///< A leaf, or a part of one, that gets nodes of its own.
        leaf,        ///< Of count_ places from first_ on.
        joined       ///< Several leaves, whose places are in joined_.
    };

    std::uint32_t open_node(std::uint32_t node) {
        open_area_.fill(Float4::filled(1.0f));
        area_.fill(-1.0f);
        if (node == 0 && is_small_root()) return 1;
        if (plan_ != nullptr) return take_planned(node, Width, 0);
        const std::uint32_t first = nodes_[node].first;
        evaluate(0, first);
        evaluate(1, first + 1);
        std::uint32_t count = 2;
        for (std::uint32_t largest = 0; count < Width && find_largest(largest); ++count) {
            const std::uint32_t opened = nodes_[node_[largest]].first;
            evaluate(largest, opened);
            evaluate(count, opened + 1);
        }
        return count;
    }

    /// Puts what the plan makes of `node` in so many slots behind the first `count` children. Returns how many there
    /// are then.
    std::uint32_t take_planned(std::uint32_t node, std::uint32_t slots, std::uint32_t count) {
        while (slots > 1 && plan_->first_share(node, slots) == 0)
            --slots;
        if (slots == 1) {
            evaluate(count, node);
            return count + 1;
        }
        const std::uint32_t first = nodes_[node].first, share = plan_->first_share(node, slots);
        count = take_planned(first, share, count);
        return take_planned(first + 1, slots - share, count);
    }

    [[nodiscard]] bool may_join(std::uint32_t node) const noexcept {
        if (plan_ == nullptr) return true;
        return node == 0 ? plan_->is_joined_root() : plan_->is_joined(node);
    }

    /// The root of a tree that goes into one leaf stays alone.
    bool is_small_root() {
        evaluate(0, 0);
        return kind_[0] != Kind::inner;
    }

    /// Finds out what node `index` becomes as the child `slot`.
    CLBVH_ALWAYS_INLINE void evaluate(std::uint32_t slot, std::uint32_t index) {
        const Node& node = nodes_[index];
        // Areas that are NaN, as those of boxes that no builder makes, count as 0.
        const float area = half_area(node.bounds());
        area_[slot] = area > 0.0f ? area : 0.0f;
        node_[slot] = index;
        first_[slot] = node.first;
        count_[slot] = node.count;
        float open_area = 1.0f;
        if (node.is_leaf()) {
            kind_[slot] = node.count > Rules::MaxLeaf ? Kind::large_leaf : Kind::leaf;
        } else if (may_join(index) && join(node.first, joined_[slot])) {
            kind_[slot] = Kind::joined;
        } else {
            kind_[slot] = Kind::inner;
            open_area = -area_[slot];
            prefetch_below_pair(node.first);
        }
        for (std::uint32_t part = 0; part < open_area_.size(); ++part) {
            open_area_[part] = select(less(Float4::filled(0.0f), lane_of_eight(slot, part)), Float4::filled(open_area),
                                      open_area_[part]);
        }
    }

    /// At least so many primitives are below a node.
    [[nodiscard]] static std::uint32_t least_below(const Node& node) noexcept {
        return node.is_leaf() ? node.count : 2;
    }

    /// Finds the places of all primitives below a pair of nodes. False where these are more than Joined.
    [[nodiscard]] bool join(std::uint32_t pair, Places& places) const {
        const Node& a = nodes_[pair];
        const Node& b = nodes_[pair + 1];
        if (least_below(a) + least_below(b) > Rules::Joined) return false;
        std::uint32_t count = 0;
        if (!join(a, places, count, least_below(b)) || !join(b, places, count, 0)) return false;
        while (count < places.size())
            places[count++] = kNone;
        return true;
    }

    /// Adds the places of all primitives below `node` to the first `count`. False where they, and `waiting` others, are
    /// more than Joined.
    bool join(const Node& node, Places& places, std::uint32_t& count, std::uint32_t waiting) const {
        if (node.is_leaf()) {
            if (count + node.count + waiting > Rules::Joined) return false;
            for (std::uint32_t i = 0; i < node.count; ++i)
                places[count++] = node.first + i;
            return true;
        }
        const Node& a = nodes_[node.first];
        const Node& b = nodes_[node.first + 1];
        if (count + least_below(a) + least_below(b) + waiting > Rules::Joined) return false;
        return join(a, places, count, waiting + least_below(b)) && join(b, places, count, waiting);
    }

    /// Of the children that can be opened. False where there is none.
    [[nodiscard]] CLBVH_ALWAYS_INLINE bool find_largest(std::uint32_t& largest) const {
        Float4 most = open_area_[0];
        for (std::uint32_t part = 1; part < open_area_.size(); ++part)
            most = min(most, open_area_[part]);
        const float area = most.least();
        std::uint32_t same = 0;
        for (std::uint32_t part = 0; part < open_area_.size(); ++part)
            same |= equal(open_area_[part], Float4::filled(area)).bits() << 4 * part;
        largest = static_cast<std::uint32_t>(std::countr_zero(same));
        return area <= 0.0f;
    }

    [[nodiscard]] std::array<std::uint8_t, Width> children_in_slots(std::uint32_t count) const {
        if constexpr (Rules::kHasGaps) {
            std::array<Box4, Width> boxes;
            for (std::uint32_t child = 0; child < count; ++child)
                boxes[child] = Box4::of(nodes_[node_[child]]);
            return OctantSlots(boxes, count).child_in();
        } else {
            return order_by_area();
        }
    }

    /// Those that are not there come last.
    [[nodiscard]] std::array<std::uint8_t, Width> order_by_area() const {
        std::array<std::uint8_t, Width> order{};
        for (std::uint32_t i = 0; i < Width; ++i) {
            const Float4 area = Float4::filled(area_[i]);
            std::uint32_t larger = 0, same = 0;
            for (std::uint32_t begin = 0; begin < Width; begin += 4) {
                const Float4 others = Float4::load(area_.data() + begin);
                larger |= less(area, others).bits() << begin;
                same |= equal(area, others).bits() << begin;
            }
            const std::uint32_t before = larger | (same & ((1U << i) - 1));
            order[kBitCounts[before & 15] + kBitCounts[before >> 4]] = static_cast<std::uint8_t>(i);
        }
        return order;
    }

    void prefetch_below_pair(std::uint32_t first) const {
        for (std::uint32_t k = 0; k < 2; ++k) {
            if (!nodes_[first + k].is_leaf()) prefetch(&nodes_[nodes_[first + k].first]);
        }
    }

    /// Equal parts, of whole blocks but for the last, all with the box of the leaf.
    std::uint32_t divide_range(const Item& item) {
        area_.fill(-1.0f);
        const std::uint32_t blocks = (item.count + Rules::Block - 1) / Rules::Block;
        const std::uint32_t part = (blocks + Width - 1) / Width * Rules::Block;
        std::uint32_t slot = 0;
        for (std::uint32_t begin = 0; begin < item.count; begin += part, ++slot) {
            node_[slot] = item.node;
            first_[slot] = item.first + begin;
            count_[slot] = std::min(part, item.count - begin);
            kind_[slot] = count_[slot] > Rules::MaxLeaf ? Kind::large_leaf : Kind::leaf;
            area_[slot] = 0.0f;
        }
        return slot;
    }

    std::uint32_t add_leaf(std::uint32_t child) {
        const auto first_block = static_cast<std::uint32_t>(piece_.blocks.size());
        if (kind_[child] == Kind::joined) {
            piece_.blocks.push_back(joined_[child]);
            return Rules::kLeaf | first_block;
        }
        std::uint32_t blocks = 0;
        for (std::uint32_t begin = 0; begin < count_[child]; begin += Rules::Block, ++blocks) {
            Places& places = piece_.blocks.emplace_back();
            for (std::uint32_t i = 0; i < places.size(); ++i)
                places[i] = i < Rules::Block && begin + i < count_[child] ? first_[child] + begin + i : kNone;
        }
        return Rules::kLeaf | (blocks - 1) << Rules::kBlockCountShift | first_block;
    }

    /// Bits that are set in four: not every processor that the library is compiled for has an instruction.
    static constexpr std::array<std::uint8_t, 16> kBitCounts = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};

    const Node* nodes_;
    Piece<Width>& piece_;
    const LeastCostOpening<Rules>* plan_;
    // Of the children of the node at hand.
    alignas(32) std::array<float, Width> area_;  ///< Half areas; -1 where there is no child.
    /// Less the same of those that can be opened; else 1. In vectors: a load of what was just stored in parts would
    /// have to wait for it.
    std::array<Float4, Width / 4> open_area_;
    std::array<std::uint32_t, Width> node_, first_, count_;
    std::array<Kind, Width> kind_;
    std::array<Places, Width> joined_;
};

/// All wide nodes of a tree, opened in parallel: the top of the tree first, level by level, then one piece for each
/// node below it. What a piece holds, and their order, depend on the tree alone.
template <typename Rules>
class Opening {
public:
    static constexpr std::uint32_t Width = Rules::Width;

    /// `nodes` are a tree, and not empty. Keeps the memory of the last run.
    void run(std::span<const Node> nodes, NodeOpening opening) {
        const bool is_planned = opening == NodeOpening::least_cost;
        if (is_planned) plan_.run(nodes);
        const LeastCostOpening<Rules>* const plan = is_planned ? &plan_ : nullptr;
        constexpr std::size_t kNodesOfPiece = 2048;
        constexpr std::size_t kMostPieces = 1024;
        const std::size_t wanted = std::min(nodes.size() / kNodesOfPiece, kMostPieces);
        if (pieces_.empty()) pieces_.emplace_back();
        std::vector<Item> queue{root_item(nodes[0])};
        std::size_t opened = 0;
        Piece<Width>& top = pieces_[0];
        begin(top);
        std::uint32_t next_number = 1;
        for (Opener<Rules> opener(nodes.data(), top, plan); opened < queue.size() && queue.size() - opened < wanted;) {
            const Item item = queue[opened++];
            opener.open(item, top.nodes.emplace_back(), next_number, queue);
        }
        count_ = 1 + queue.size() - opened;
        if (pieces_.size() < count_) pieces_.resize(count_);
        tbb::parallel_for(
            std::size_t{1}, count_,
            [&](std::size_t i) {
                pieces_[i].root = static_cast<std::uint32_t>(opened + i - 1);
                open_piece(nodes.data(), pieces_[i], queue[opened + i - 1], plan);
            },
            tbb::simple_partitioner{});
        number_pieces(next_number);
    }

    [[nodiscard]] std::span<const Piece<Width>> pieces() const noexcept { return {pieces_.data(), count_}; }
    [[nodiscard]] std::uint64_t node_count() const noexcept { return node_count_; }
    [[nodiscard]] std::uint64_t block_count() const noexcept { return block_count_; }
    [[nodiscard]] std::uint32_t depth() const noexcept { return depth_; }

private:
    using Item = typename Opener<Rules>::Item;
    static constexpr std::size_t kItemsAhead = 6;

    static Item root_item(const Node& root) {
        const bool is_large_leaf = root.count > Rules::MaxLeaf;
        return {0, 1, is_large_leaf ? root.first : 0, is_large_leaf ? root.count : 0};
    }

    static void begin(Piece<Width>& piece) {
        piece.nodes.clear();
        piece.blocks.clear();
        piece.depth = 0;
    }

    /// Level by level, so that what an item needs can be asked for in time.
    static void open_piece(const Node* nodes, Piece<Width>& piece, const Item& root,
                           const LeastCostOpening<Rules>* plan) {
        begin(piece);
        Opener<Rules> opener(nodes, piece, plan);
        std::uint32_t next_number = 0;
        std::vector<Item> queue;
        opener.open(root, piece.root_node, next_number, queue);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            if (i + kItemsAhead < queue.size()) opener.prefetch_for(queue[i + kItemsAhead]);
            const Item item = queue[i];
            opener.open(item, piece.nodes.emplace_back(), next_number, queue);
        }
    }

    /// `top_count` nodes come first: those of the first piece, and the roots of the others.
    void number_pieces(std::uint32_t top_count) {
        node_count_ = top_count;
        block_count_ = 0;
        depth_ = 0;
        for (Piece<Width>& piece : std::span(pieces_).first(count_)) {
            const bool is_top = &piece == pieces_.data();
            piece.first_node = is_top ? 0 : static_cast<std::uint32_t>(node_count_);
            piece.first_block = static_cast<std::uint32_t>(block_count_);
            if (!is_top) node_count_ += piece.nodes.size();
            block_count_ += piece.blocks.size();
            depth_ = std::max(depth_, piece.depth);
        }
    }

    LeastCostOpening<Rules> plan_;
    std::vector<Piece<Width>> pieces_;  // the first is the top of the tree
    std::size_t count_ = 0;             // of them, in the last run
    std::uint64_t node_count_ = 0;
    std::uint64_t block_count_ = 0;
    std::uint32_t depth_ = 0;
};

}  // namespace clbvh::layout
