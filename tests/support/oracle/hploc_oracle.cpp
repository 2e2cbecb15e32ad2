#include "support/oracle/hploc_oracle.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>
#include <vector>

namespace clbvh::test {
namespace {

struct Cluster {
    Node node;
    std::uint32_t first;      ///< Smallest Morton position of its leaves.
    std::uint32_t place = 0;  ///< Among those that its node of the Morton tree began with.
};

using Clusters = std::vector<Cluster>;

Node make_node(const Aabb& box, std::uint32_t first, std::uint32_t count) {
    return {{box.lower.x, box.lower.y, box.lower.z}, first, {box.upper.x, box.upper.y, box.upper.z}, count};
}

class HplocOracle {
public:
    HplocOracle(const MortonOrder& order, const HplocConfig& options, std::vector<Node>& nodes)
        : order_(order), options_(options), nodes_(nodes) {}

    /// The clusters that the node of the Morton tree over [begin, end) leaves.
    Clusters clusters_of(std::uint32_t begin, std::uint32_t end) {
        if (end - begin == 1) return {{make_node(order_.bounds[begin], begin, 1), begin}};
        const std::uint32_t split = split_position(order_.codes, begin, end);
        Clusters clusters = clusters_of(begin, split);
        const Clusters right = clusters_of(split, end);
        clusters.insert(clusters.end(), right.begin(), right.end());
        const std::uint32_t kept = end - begin == order_.ids.size() ? 1 : limit_of(end - begin);
        number_places(clusters);
        while (clusters.size() > kept) {
            merge_mutual_pairs(clusters);
            if (options_.search_radius > 0) number_places(clusters);
        }
        return clusters;
    }

private:
    [[nodiscard]] std::uint32_t limit_of(std::uint32_t leaves) const {
        if (leaves == 2 && options_.merge_pairs) return 1;
        return leaves <= options_.small_range ? options_.small_limit : options_.cluster_limit;
    }

    static void number_places(Clusters& clusters) {
        std::uint32_t place = 0;
        for (Cluster& cluster : clusters)
            cluster.place = place++;
    }

    /// Half area without its lowest five bits, instead of which stands the difference of the places.
    static std::uint32_t key(const Clusters& clusters, std::size_t i, std::size_t j) {
        const float distance = half_area(merge(clusters[i].node.bounds(), clusters[j].node.bounds()));
        return (std::bit_cast<std::uint32_t>(distance) & ~31u) | (clusters[i].place ^ clusters[j].place);
    }

    [[nodiscard]] std::size_t nearest(const Clusters& clusters, std::size_t i) const {
        const std::size_t reach = options_.search_radius > 0 ? options_.search_radius : clusters.size();
        std::size_t best = i;
        for (std::size_t j = i - std::min(i, reach); j < std::min(i + reach + 1, clusters.size()); ++j) {
            if (j != i && (best == i || key(clusters, i, j) < key(clusters, i, best))) best = j;
        }
        return best;
    }

    /// The parent of a pair takes the place of its left child; all others keep theirs, and all keep their order.
    void merge_mutual_pairs(Clusters& clusters) {
        std::vector<std::size_t> neighbours;
        for (std::size_t i = 0; i < clusters.size(); ++i)
            neighbours.push_back(nearest(clusters, i));
        Clusters kept;
        for (std::size_t i = 0; i < clusters.size(); ++i) {
            const std::size_t j = neighbours[i];
            const bool is_mutual = neighbours[j] == i;
            if (is_mutual && i < j) kept.push_back(join(clusters[i], clusters[j]));
            if (!is_mutual) kept.push_back(clusters[i]);
        }
        if (kept.size() == clusters.size()) throw std::logic_error("no two clusters are each other's nearest");
        clusters = std::move(kept);
    }

    Cluster join(const Cluster& left, const Cluster& right) {
        const std::uint32_t pair = 2 * right.first;
        nodes_[pair] = left.node;
        nodes_[pair + 1] = right.node;
        return {make_node(merge(left.node.bounds(), right.node.bounds()), pair, 0), left.first, left.place};
    }

    const MortonOrder& order_;
    HplocConfig options_;
    std::vector<Node>& nodes_;
};

/// Leaves as primitives of their own, and where in the order of the primitives each begins.
struct Leaves {
    MortonOrder order;
    std::vector<std::uint32_t> begins;
};

/// Adds the leaves of the node of the Morton tree over [begin, end).
void add_leaves(const MortonOrder& order, std::uint32_t begin, std::uint32_t end, std::uint32_t leaf_size,
                Leaves& leaves) {
    if (end - begin > leaf_size) {
        const std::uint32_t split = split_position(order.codes, begin, end);
        add_leaves(order, begin, split, leaf_size, leaves);
        add_leaves(order, split, end, leaf_size, leaves);
        return;
    }
    Aabb box;
    for (std::uint32_t position = begin; position < end; ++position)
        box = merge(box, order.bounds[position]);
    leaves.begins.push_back(begin);
    leaves.order.codes.push_back(order.codes[begin]);
    leaves.order.ids.push_back(begin);
    leaves.order.bounds.push_back(box);
}

}  // namespace

OracleTree hploc_tree(const MortonOrder& order, const HplocConfig& options) {
    OracleTree tree = empty_tree(order);
    if (order.ids.empty()) return tree;
    const auto primitives = static_cast<std::uint32_t>(order.ids.size());
    Leaves leaves;
    add_leaves(order, 0, primitives, options.leaf_size, leaves);
    leaves.begins.push_back(primitives);
    const auto leaf_count = static_cast<std::uint32_t>(leaves.order.ids.size());
    tree.bvh.nodes.assign(2 * leaf_count, {});
    HplocOracle oracle(leaves.order, options, tree.bvh.nodes);
    tree.bvh.nodes[0] = oracle.clusters_of(0, leaf_count).front().node;
    for (Node& node : tree.bvh.nodes) {
        if (!node.is_leaf()) continue;
        const std::uint32_t leaf = node.first;
        node.first = leaves.begins[leaf];
        node.count = leaves.begins[leaf + 1] - leaves.begins[leaf];
    }
    return tree;
}

}  // namespace clbvh::test
