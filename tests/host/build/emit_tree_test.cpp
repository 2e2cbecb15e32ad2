// Emission: whatever the numbering and the holes, the tree that comes out is the one that went in, depth first.
#include "host/build/emit_tree.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

#include "support/builders.hpp"
#include "support/compare_trees.hpp"

using namespace clbvh;
using namespace clbvh::test;
using host::Extent;

namespace {

/// A tree of random shape over `leaves` leaves, whose pairs lie in shuffled slots.
struct RandomTree {
    std::vector<Node> nodes;
    std::vector<Extent> extents;
    std::vector<std::uint32_t> ids;

    RandomTree(std::uint32_t leaves, std::uint32_t seed, bool chain = false) : random_(seed), chain_(chain) {
        nodes.resize(4 * std::size_t{leaves});  // twice as many slots as needed: holes
        extents.resize(2 * std::size_t{leaves});
        pairs_.resize(extents.size() - 1);
        std::iota(pairs_.begin(), pairs_.end(), 1u);
        std::ranges::shuffle(pairs_, random_);
        grow(leaves);
    }

    [[nodiscard]] host::TreeSlots slots() const { return {nodes, extents, ids}; }

    /// The same tree as a Bvh, without emit_tree.
    [[nodiscard]] Bvh as_it_lies() const {
        Bvh bvh;
        bvh.nodes = nodes;
        bvh.primitive_ids = ids;
        bvh.primitive_count = ids.size();
        return bvh;
    }

private:
    struct Open {
        std::uint32_t node, leaves, pair;
    };

    /// Top-down without recursion, since chains are deep; then extents bottom-up.
    void grow(std::uint32_t leaves) {
        std::vector<Open> open{{0, leaves, 0}}, inner;
        while (!open.empty()) {
            const Open top = open.back();
            open.pop_back();
            nodes[top.node].lower[0] = static_cast<float>(random_() % 1000);
            if (top.leaves == 1) {
                make_leaf(top.node);
                continue;
            }
            const std::uint32_t pair = pairs_.back();
            pairs_.pop_back();
            nodes[top.node].first = 2 * pair;
            const auto part = static_cast<std::uint32_t>(random_() % (top.leaves - 1));
            const std::uint32_t left = 1 + (chain_ ? 0 : part);
            inner.push_back({top.node, top.leaves, pair});
            open.push_back({2 * pair + 1, top.leaves - left, 0});
            open.push_back({2 * pair, left, 0});
        }
        for (auto i = inner.rbegin(); i != inner.rend(); ++i) {
            const Extent left = host::extent_of(nodes[2 * i->pair], extents);
            const Extent right = host::extent_of(nodes[2 * i->pair + 1], extents);
            extents[i->pair] = {left.pairs + right.pairs + 1, left.primitives + right.primitives};
        }
    }

    void make_leaf(std::uint32_t node) {
        nodes[node].first = static_cast<std::uint32_t>(ids.size());
        nodes[node].count = 1 + static_cast<std::uint32_t>(random_() % 3);
        for (std::uint32_t i = 0; i < nodes[node].count; ++i)
            ids.push_back(static_cast<std::uint32_t>(ids.size() * 48271 % 2147483647));  // no two alike, no order
    }

    std::mt19937 random_;
    bool chain_;
    std::vector<std::uint32_t> pairs_;
};

/// Depth first: the pairs that a walk from the root meets follow each other, and so do the ids.
void expect_depth_first(const Bvh& bvh) {
    std::uint32_t next_pair = 1, next_id = 0;
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
        const Node node = bvh.nodes[open.back()];
        open.pop_back();
        REQUIRE(node.first == (node.is_leaf() ? next_id : 2 * next_pair));
        if (node.is_leaf()) {
            next_id += node.count;
            continue;
        }
        ++next_pair;
        open.push_back(node.first + 1);
        open.push_back(node.first);
    }
    CHECK(2 * next_pair == bvh.nodes.size());
    CHECK(next_id == bvh.primitive_ids.size());
    CHECK(bvh.nodes[1] == Node{});
}

}  // namespace

TEST_CASE("emission keeps the tree and leaves no hole") {
    for (const std::uint32_t leaves : {1u, 2u, 3u, 10u, 1000u, 30000u}) {
        const RandomTree tree(leaves, leaves);
        Bvh bvh;
        host::emit_tree(tree.slots(), bvh);
        bvh.primitive_count = tree.ids.size();
        CHECK(compare_trees(tree.as_it_lies(), bvh) == "");
        CHECK(bvh.nodes.size() == 2 * std::size_t{leaves});
        expect_depth_first(bvh);
    }
}

TEST_CASE("emission overwrites an older tree") {
    const RandomTree large(5000, 1), small(100, 2);
    Bvh bvh, fresh;
    host::emit_tree(large.slots(), bvh);
    host::emit_tree(small.slots(), bvh);
    host::emit_tree(small.slots(), fresh);
    CHECK(same_bytes(bvh, fresh));
}

TEST_CASE("emission flattens the inner nodes that ask for it") {
    RandomTree tree(2000, 3);
    const Bvh before = tree.as_it_lies();
    // Every inner node with at most nine primitives below.
    for (std::size_t pair = 1; pair < tree.extents.size(); ++pair) {
        if (tree.extents[pair].pairs > 0 && tree.extents[pair].primitives <= 9) tree.extents[pair].pairs = 0;
    }
    // Nodes above a flattened one have fewer pairs now: count again, children first.
    const auto recount = [&](const auto& self, const Node& node) -> std::uint32_t {
        if (node.is_leaf() || tree.extents[node.first / 2].pairs == 0) return 0;
        const std::uint32_t left = self(self, tree.nodes[node.first]);
        const std::uint32_t right = self(self, tree.nodes[node.first + 1]);
        return tree.extents[node.first / 2].pairs = left + right + 1;
    };
    recount(recount, tree.nodes[0]);
    Bvh bvh;
    host::emit_tree(tree.slots(), bvh);
    expect_depth_first(bvh);
    CHECK(bvh.nodes.size() < before.nodes.size() / 4);
    // Every leaf holds the ids that were in its place, in ascending order where it was flattened.
    Bvh whole;
    const RandomTree same(2000, 3);
    host::emit_tree(same.slots(), whole);
    for (const Node& node : bvh.nodes) {
        if (node.count <= 3) continue;
        CHECK(node.count <= 9);
        const auto first = static_cast<std::ptrdiff_t>(node.first),
                   end = first + static_cast<std::ptrdiff_t>(node.count);
        std::vector<std::uint32_t> expected(whole.primitive_ids.begin() + first, whole.primitive_ids.begin() + end);
        std::ranges::sort(expected);
        CHECK(std::equal(expected.begin(), expected.end(), bvh.primitive_ids.begin() + first));
    }
}

TEST_CASE("emission takes little stack on a chain 200,000 nodes deep") {
    const RandomTree chain(200000, 4, true);
    Bvh bvh;
    host::emit_tree(chain.slots(), bvh);
    expect_depth_first(bvh);
}
