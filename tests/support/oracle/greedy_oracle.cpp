#include "support/oracle/greedy_oracle.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <tuple>
#include <vector>

namespace clbvh::test {
namespace {

/// One inner node: the clusters of its children become one.
struct Merge {
    float distance;
    std::uint32_t primitives;  ///< Of the merged cluster: decides between a merge and those below it.
    std::uint32_t left;        ///< One primitive of each child stands for it.
    std::uint32_t right;
};

/// All merges of a tree, in the order of greedy clustering.
class Replay {
public:
    explicit Replay(const Bvh& bvh) : bvh_(bvh) {
        visit(bvh.nodes[0]);
        std::ranges::sort(merges_, {}, [](const Merge& merge) { return std::tuple(merge.distance, merge.primitives); });
    }

    [[nodiscard]] const std::vector<Merge>& merges() const { return merges_; }

private:
    struct Subtree {
        std::uint32_t primitives;
        std::uint32_t primitive;
    };

    Subtree visit(const Node& node) {
        if (node.is_leaf()) return {node.count, bvh_.primitive_ids[node.first]};
        const Subtree left = visit(bvh_.nodes[node.first]);
        const Subtree right = visit(bvh_.nodes[node.first + 1]);
        const std::uint32_t primitives = left.primitives + right.primitives;
        merges_.push_back({half_area(node.bounds()), primitives, left.primitive, right.primitive});
        return {primitives, left.primitive};
    }

    const Bvh& bvh_;
    std::vector<Merge> merges_;
};

/// The clusters of greedy clustering, each with its nearest one.
class Clusters {
public:
    explicit Clusters(std::span<const Aabb> boxes) : cluster_of_(boxes.size()) {
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            cluster_of_[i] = i;
            clusters_.push_back({boxes[i], true, 0, 0.0f});
        }
        for (std::size_t i = 0; i < boxes.size(); ++i)
            find_nearest(i);
    }

    [[nodiscard]] float least_distance() const {
        float least = std::numeric_limits<float>::infinity();
        for (const Cluster& cluster : clusters_) {
            if (cluster.is_alive) least = std::min(least, cluster.distance);
        }
        return least;
    }

    void merge_of(std::uint32_t left_primitive, std::uint32_t right_primitive) {
        const std::size_t left = find(left_primitive);
        const std::size_t right = find(right_primitive);
        clusters_[left].box = merge(clusters_[left].box, clusters_[right].box);
        clusters_[right].is_alive = false;
        cluster_of_[right] = left;
        for (std::size_t i = 0; i < clusters_.size(); ++i) {
            if (!clusters_[i].is_alive) continue;
            const bool lost_nearest = clusters_[i].nearest == left || clusters_[i].nearest == right;
            if (i == left || lost_nearest) find_nearest(i);
        }
    }

private:
    struct Cluster {
        Aabb box;
        bool is_alive;
        std::size_t nearest;
        float distance;
    };

    [[nodiscard]] std::size_t find(std::size_t cluster) const {
        while (cluster_of_[cluster] != cluster)
            cluster = cluster_of_[cluster];
        return cluster;
    }

    void find_nearest(std::size_t i) {
        clusters_[i].distance = std::numeric_limits<float>::infinity();
        for (std::size_t j = 0; j < clusters_.size(); ++j) {
            if (j == i || !clusters_[j].is_alive) continue;
            const float distance = half_area(merge(clusters_[i].box, clusters_[j].box));
            if (distance >= clusters_[i].distance) continue;
            clusters_[i].distance = distance;
            clusters_[i].nearest = j;
        }
    }

    std::vector<std::size_t> cluster_of_;  // another cluster where this one has merged into it
    std::vector<Cluster> clusters_;
};

}  // namespace

std::string check_greedy(const Bvh& bvh, std::span<const Aabb> boxes) {
    Clusters clusters(boxes);
    const Replay replay(bvh);
    for (const Merge& merge : replay.merges()) {
        const float least = clusters.least_distance();
        if (merge.distance != least) {
            return "the cluster of " + std::to_string(merge.primitives) + " primitives with " +
                   std::to_string(merge.left) + " and " + std::to_string(merge.right) + " has half area " +
                   std::to_string(merge.distance) + ", but two clusters were as close as " + std::to_string(least);
        }
        clusters.merge_of(merge.left, merge.right);
    }
    return {};
}

}  // namespace clbvh::test
