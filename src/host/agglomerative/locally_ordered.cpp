// Greedy agglomerative clustering, in local order. Walter, Bala, Kulkarni, Pingali 2008, "Fast agglomerative clustering
// for rendering".
//
// The half area of the common box is reducible: a merged cluster is no nearer to any other than the nearer of its two
// parts was. Two clusters that are each other's nearest therefore may merge at any time, and the tree is the greedy
// one. The paper merges one such pair after the other, its clusters in a kd-tree; here all pairs merge at once, in
// rounds, as long as rounds find enough of them, and along a chain of nearest neighbours, which takes a bounded number
// of searches for each merge, where they do not. Choices depend on counts alone, never on threads.
#include "host/agglomerative/locally_ordered.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>

#include "host/agglomerative/cluster_tree.hpp"
#include "host/agglomerative/kd_order.hpp"
#include "host/build/emit_tree.hpp"

namespace clbvh::host {
namespace {

/// Slots that one task looks after.
constexpr std::uint32_t kChunk = 256;
/// A round that searches more often than this for each of its merges is followed by a chain.
constexpr std::uint32_t kMostSearchesPerMerge = 16;
/// Looking at this many slots takes about as long as one search.
constexpr std::uint32_t kSlotsPerSearch = 32;
/// A chain goes on until one of this many clusters has merged.
constexpr std::uint32_t kChainPart = 8;

/// A cluster is a Reference. `primitive` is its identity: 2 p + 1 of the primitive whose position is p, or the slot of
/// its left child in the tree; 0 where the cluster has merged into another. `unused` is the smallest position of its
/// primitives.
using Cluster = Reference;

/// The nearest cluster as it was found, valid as long as the slot holds the cluster of this identity.
struct Nearest {
    std::uint32_t slot;
    std::uint32_t identity;
};

/// Counts of one round.
struct Round {
    std::uint32_t slots = 0;
    std::uint32_t searches = 0;
    std::uint32_t merges = 0;

    [[nodiscard]] bool pays() const noexcept {
        return searches + slots / kSlotsPerSearch <= std::uint64_t{merges} * kMostSearchesPerMerge;
    }
};

class LocallyOrderedBuilder {
public:
    explicit LocallyOrderedBuilder(HostBuild& build)
        : build_(build),
          nodes_(build.scratch.take<Node>(2 * build.references.size())),
          extents_(build.scratch.take<Extent>(build.references.size())),
          primitive_ids_(build.scratch.take<std::uint32_t>(build.references.size())),
          nearest_(build.scratch.take<Nearest>(build.references.size())),
          chain_(build.scratch.take<std::uint32_t>(build.references.size())),
          tree_(build.scratch, build.references.size()),
          clusters_(build.references),
          alive_(static_cast<std::uint32_t>(build.references.size())) {}

    void run() {
        build_.stages.begin("order", 0.05, 0.15);
        order_by_kd_tree(clusters_);
        make_leaves();
        build_.stages.begin("cluster", 0.15, 0.95, alive_);
        index_clusters();
        while (alive_ > 1) {
            const bool is_sparse = alive_ <= clusters_.size() / 2;
            if (is_sparse) reorder();
            const Round round = merge_round();
            if (!is_sparse && !round.pays()) merge_chain();
        }
        nodes_[0] = node_of(*std::ranges::find_if(clusters_, is_alive));
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree({nodes_, extents_, primitive_ids_}, build_.result);
    }

private:
    static bool is_alive(const Cluster& cluster) noexcept { return cluster.primitive != 0; }

    [[nodiscard]] bool has_nearest(std::uint32_t slot) const noexcept {
        return clusters_[nearest_[slot].slot].primitive == nearest_[slot].identity;
    }

    void make_leaves() {
        tbb::parallel_for(0u, alive_, [&](std::uint32_t position) {
            Cluster& cluster = clusters_[position];
            primitive_ids_[position] = cluster.primitive;
            cluster.primitive = 2 * position + 1;
            cluster.unused = position;
        });
    }

    static Node node_of(const Cluster& cluster) noexcept {
        const bool is_leaf = cluster.primitive % 2 == 1;
        return make_node(Box4::of(cluster), is_leaf ? cluster.primitive / 2 : cluster.primitive, is_leaf ? 1 : 0);
    }

    /// Makes the tree over the clusters afresh. All are to find their nearest again: ties are decided by slots.
    void index_clusters() {
        tree_.assign(clusters_);
        std::ranges::fill(nearest_.first(clusters_.size()), Nearest{0, kNobody});
    }

    /// Closes the gaps.
    void reorder() {
        const auto end = std::remove_if(clusters_.begin(), clusters_.end(), std::not_fn(is_alive));
        clusters_ = {clusters_.begin(), end};
        order_by_kd_tree(clusters_);
        index_clusters();
    }

    /// Merges all pairs that are each other's nearest.
    Round merge_round() {
        Round round;
        round.slots = static_cast<std::uint32_t>(clusters_.size());
        round.searches =
            sum_over_slots([&](std::uint32_t slot) { return is_alive(clusters_[slot]) && update_nearest(slot); });
        round.merges = sum_over_slots([&](std::uint32_t slot) { return merge_if_mutual(slot); });
        tree_.refit();
        alive_ -= round.merges;
        build_.stages.advance(round.merges);
        return round;
    }

    /// Calls `work` for each slot, in parallel; returns how often it was true.
    template <typename Work>
    std::uint32_t sum_over_slots(const Work& work) const {
        return tbb::parallel_reduce(
            tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(clusters_.size()), kChunk), 0u,
            [&](const auto& range, std::uint32_t sum) {
                for (std::uint32_t slot = range.begin(); slot < range.end(); ++slot)
                    sum += work(slot) ? 1 : 0;
                build_.stages.advance(0);
                return sum;
            },
            std::plus<>{});
    }

    /// Searches where the nearest cluster is not known. Returns whether it did.
    bool update_nearest(std::uint32_t slot) const noexcept {
        if (has_nearest(slot)) return false;
        const std::uint32_t nearest = tree_.find_nearest(slot, clusters_[slot]).slot;
        nearest_[slot] = {nearest, clusters_[nearest].primitive};
        return true;
    }

    bool merge_if_mutual(std::uint32_t slot) noexcept {
        const std::uint32_t other = nearest_[slot].slot;
        // In this order: the cluster of a slot whose nearest lies before it may be merging at this moment.
        if (other < slot || !is_alive(clusters_[slot]) || nearest_[other].slot != slot) return false;
        merge(slot, other);
        return true;
    }

    /// Merges into slot `a`, and leaves `b` empty. One of the two positions ends: that numbers the pair of children.
    void merge(std::uint32_t a, std::uint32_t b) noexcept {
        Cluster& left = clusters_[clusters_[a].unused < clusters_[b].unused ? a : b];
        Cluster& right = clusters_[clusters_[a].unused < clusters_[b].unused ? b : a];
        const std::uint32_t ended = right.unused;
        const std::uint32_t position = left.unused;
        const Node left_node = nodes_[2 * std::size_t{ended}] = node_of(left);
        const Node right_node = nodes_[2 * std::size_t{ended} + 1] = node_of(right);
        const Extent left_extent = extent_of(left_node, extents_);
        const Extent right_extent = extent_of(right_node, extents_);
        extents_[ended] = {left_extent.pairs + right_extent.pairs + 1,
                           left_extent.primitives + right_extent.primitives};
        Box4 box = Box4::of(left);
        box.merge(Box4::of(right));
        Cluster& merged = clusters_[a];
        box.lower.store(merged.lower);  // the fourth lanes are written next
        box.upper.store(merged.upper);
        merged.primitive = 2 * ended;
        merged.unused = position;
        clusters_[b].primitive = 0;
        tree_.set(a, merged);
        tree_.clear(b);
    }

    /// Merges pairs one by one, each found by going from a cluster to its nearest, to that one's nearest, and so on,
    /// where distances fall until two are each other's nearest.
    void merge_chain() {
        const std::uint32_t goal = alive_ - std::max(alive_ / kChainPart, 1u);
        std::size_t length = 0;
        std::uint32_t next_start = 0;
        while (alive_ > goal) {
            if (length == 0) {
                while (!is_alive(clusters_[next_start]))
                    ++next_start;
                chain_[length++] = next_start;
            }
            const std::uint32_t last = chain_[length - 1];
            update_nearest(last);
            const std::uint32_t nearest = nearest_[last].slot;
            if (length < 2 || chain_[length - 2] != nearest) {
                chain_[length++] = nearest;
                continue;
            }
            length -= 2;
            merge(std::min(last, nearest), std::max(last, nearest));
            tree_.refit_above(last);
            tree_.refit_above(nearest);
            --alive_;
            build_.stages.advance(1);
        }
    }

    /// An identity that no cluster has.
    static constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

    HostBuild& build_;
    std::span<Node> nodes_;
    std::span<Extent> extents_;
    std::span<std::uint32_t> primitive_ids_;
    std::span<Nearest> nearest_;
    std::span<std::uint32_t> chain_;
    ClusterTree tree_;
    std::span<Cluster> clusters_;  // slot by slot, the empty ones included
    std::uint32_t alive_;
};

}  // namespace

void build_locally_ordered(HostBuild& build) {
    LocallyOrderedBuilder(build).run();
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_locally_ordered(const Primitives& primitives) {
    return host::build_over(primitives, [](host::HostBuild& build) { host::build_locally_ordered(build); });
}

}  // namespace clbvh
