#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/bvh.hpp"
#include "core/scratch.hpp"

namespace clbvh::host {

/// A half area that about the part `share` of a tree's inner nodes have more than, or about a thousand nodes where
/// these are more; below 0 where that are all. Found by samples.
[[nodiscard]] float area_limit(std::span<const Node> nodes, double share);

/// The inner nodes at the top of a tree that are larger than a limit. The subtrees below them, leaves or smaller ones,
/// are clusters, which stay as they are.
class ClusterTop {
public:
    struct Inner {
        double half_area;
        std::uint32_t slot;           ///< Where the node is.
        std::uint32_t pair;           ///< Slot of its left child.
        std::uint32_t first_cluster;  ///< Those below it lie together,
        std::uint32_t cluster_count;  ///< so many of them.
    };
    /// In preorder, left before right: the subtree over c clusters at inner[i] is inner[i] to inner[i + c - 2].
    std::vector<Inner> inner;
    std::vector<Node> clusters;  ///< Their roots, from left to right.

    /// Replaces what it held by the top below `root`, which belongs to `slot` and need not stand there: its nodes have
    /// half areas above `limit`. No node is larger than its parent, so that there is none of them below a cluster.
    void gather(std::span<const Node> nodes, std::uint32_t slot, const Node& root, float limit);

    /// The children of inner[i] in `inner`, kCluster for each that is a cluster.
    static constexpr std::uint32_t kCluster = ~0u;
    [[nodiscard]] std::array<std::uint32_t, 2> children(std::uint32_t i) const noexcept;

private:
    void count_clusters() noexcept;

    std::vector<std::uint32_t> level_order_;  // pairs of the top
};

/// A top-down builder of trees with one box a leaf.
using BoxBuilder = void (*)(std::span<const Aabb> boxes, Scratch& scratch, Bvh& result);
void build_by_bins(std::span<const Aabb> boxes, Scratch& scratch, Bvh& result);
void build_by_sweep(std::span<const Aabb> boxes, Scratch& scratch, Bvh& result);

/// The memory that a thread builds tops in. It stays: fresh pages would cost more than a small build.
struct TopWorkspace {
    std::vector<Aabb> boxes;
    Scratch scratch;
    Bvh tree;
};

/// What building the top of one tree takes, kept for the next.
struct TopMemory {
    ClusterTop top;
    TopWorkspace workspace;
};

/// Builds the subtree of `top` at `inner` anew over its clusters' boxes, and writes it over the old one, into the same
/// slots of `nodes`, where the sum of its inner nodes' half areas is lower. Returns what that took off the sum, 0 where
/// the old one stays. Other subtrees of the top that have no node in common with it may be built at the same time.
double rebuild_top(std::span<Node> nodes, const ClusterTop& top, std::uint32_t inner, BoxBuilder builder,
                   TopWorkspace& workspace);

}  // namespace clbvh::host
