#include "support/oracle/tree_oracle.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string>
#include <utility>

#include "host/top_down/cluster_top.hpp"
#include "support/oracle/hploc_oracle.hpp"

namespace clbvh::test {
namespace {

struct Cluster {
    Node node;
    std::uint32_t position;  ///< Smallest Morton position of its primitives.
};

using Clusters = std::vector<Cluster>;

Node make_node(const Aabb& box, std::uint32_t first, std::uint32_t count) {
    return {{box.lower.x, box.lower.y, box.lower.z}, first, {box.upper.x, box.upper.y, box.upper.z}, count};
}

/// Clusters primitives step by step into the nodes of one tree.
class PlocOracle {
public:
    PlocOracle(std::uint32_t radius, Comparison comparison, std::vector<Node>& nodes)
        : radius_(radius), packed_(comparison == Comparison::packed), nodes_(nodes) {}

    /// Repeats rounds while there are more than `target` clusters. Returns the count at the start of each round.
    std::vector<std::uint32_t> reduce(Clusters& clusters, std::size_t target) {
        std::vector<std::uint32_t> counts;
        while (clusters.size() > target) {
            counts.push_back(static_cast<std::uint32_t>(clusters.size()));
            merge_mutual_pairs(clusters);
            if (clusters.size() == counts.back()) throw std::logic_error("no two clusters are each other's nearest");
        }
        return counts;
    }

private:
    using Key = std::pair<std::uint32_t, std::uint32_t>;

    Key key(const Clusters& clusters, std::size_t i, std::size_t j) const {
        const float distance = half_area(merge(clusters[i].node.bounds(), clusters[j].node.bounds()));
        const auto bits = std::bit_cast<std::uint32_t>(distance);
        const auto offset = static_cast<std::uint32_t>(i ^ j);
        if (!packed_) return {bits, offset};
        const std::uint32_t mask = std::bit_ceil(2 * radius_ + 1) - 1;
        return {((bits << 1) & ~mask) | (offset & mask), 0};
    }

    std::size_t nearest(const Clusters& clusters, std::size_t i) const {
        const std::size_t begin = i - std::min<std::size_t>(i, radius_);
        const std::size_t end = std::min(i + radius_ + 1, clusters.size());
        std::size_t best = i == begin ? i + 1 : begin;
        Key best_key = key(clusters, i, best);
        for (std::size_t j = best + 1; j < end; ++j) {
            if (j == i) continue;
            const Key candidate = key(clusters, i, j);
            if (candidate >= best_key) continue;
            best = j;
            best_key = candidate;
        }
        return best;
    }

    void merge_mutual_pairs(Clusters& clusters) {
        std::vector<std::size_t> neighbours(clusters.size());
        for (std::size_t i = 0; i < clusters.size(); ++i)
            neighbours[i] = nearest(clusters, i);
        Clusters next;
        for (std::size_t i = 0; i < clusters.size(); ++i) {
            const std::size_t j = neighbours[i];
            const bool mutual = neighbours[j] == i;
            if (!mutual) next.push_back(clusters[i]);
            if (mutual && i < j) next.push_back(join(clusters[i], clusters[j]));
        }
        clusters = std::move(next);
    }

    Cluster join(const Cluster& left, const Cluster& right) {
        const std::uint32_t pair = 2 * right.position;
        nodes_[pair] = left.node;
        nodes_[pair + 1] = right.node;
        return {make_node(merge(left.node.bounds(), right.node.bounds()), pair, 0), left.position};
    }

    std::uint32_t radius_;
    bool packed_;
    std::vector<Node>& nodes_;
};

/// Half-open, of Morton positions.
struct Range {
    std::uint32_t begin;
    std::uint32_t end;
    [[nodiscard]] std::uint32_t size() const { return end - begin; }
};

std::vector<Range> split_ranges(const MortonOrder& order, std::uint32_t radius, std::uint32_t range_count) {
    std::vector<Range> ranges{{0, static_cast<std::uint32_t>(order.codes.size())}};
    for (;;) {
        std::uint32_t largest = 0;
        for (const Range& range : ranges)
            largest = std::max(largest, range.size());
        if (ranges.size() >= range_count || largest <= radius) return ranges;
        std::vector<Range> next;
        for (const Range& range : ranges) {
            if (2 * range.size() > largest && range.size() > radius) {
                const std::uint32_t split = split_position(order.codes, range.begin, range.end);
                next.push_back({range.begin, split});
                next.push_back({split, range.end});
            } else {
                next.push_back(range);
            }
        }
        ranges = std::move(next);
    }
}

Clusters make_leaves(const MortonOrder& order, Range range) {
    Clusters clusters;
    for (std::uint32_t p = range.begin; p < range.end; ++p)
        clusters.push_back({make_node(order.bounds[p], p, 1), p});
    return clusters;
}

}  // namespace

std::uint32_t split_position(const std::vector<std::uint64_t>& codes, std::uint32_t begin, std::uint32_t end) {
    const std::uint32_t last = end - 1;
    const std::uint64_t difference = codes[begin] ^ codes[last];
    if (difference == 0) {
        const int shift = static_cast<int>(std::bit_width(begin ^ last)) - 1;
        return (last >> shift) << shift;
    }
    const std::uint64_t bit = std::bit_floor(difference);
    std::uint32_t split = begin;
    while ((codes[split] & bit) == 0)
        ++split;
    return split;
}

OracleTree empty_tree(const MortonOrder& order) {
    OracleTree tree;
    tree.bvh.primitive_count = order.primitive_count;
    tree.bvh.primitive_ids = order.ids;
    tree.bvh.nodes.resize(2 * order.ids.size());
    return tree;
}

OracleTree ploc_tree(const MortonOrder& order, std::uint32_t radius, Comparison comparison) {
    return two_level_tree(order, radius, comparison, 1);
}

OracleTree two_level_tree(const MortonOrder& order, std::uint32_t radius, Comparison comparison,
                          std::uint32_t range_count) {
    OracleTree tree = empty_tree(order);
    if (order.ids.empty()) return tree;
    PlocOracle oracle(radius, comparison, tree.bvh.nodes);
    Clusters top;
    const std::vector<Range> ranges = split_ranges(order, radius, range_count);
    for (const Range& range : ranges) {
        Clusters clusters = make_leaves(order, range);
        if (ranges.size() > 1) oracle.reduce(clusters, radius);
        top.insert(top.end(), clusters.begin(), clusters.end());
    }
    tree.clusters_per_iteration = oracle.reduce(top, 1);
    tree.bvh.nodes[0] = top[0].node;
    return tree;
}

OracleTree lbvh_tree(const MortonOrder& order) {
    struct Task {
        Range range;
        std::uint32_t slot;
    };
    OracleTree tree = empty_tree(order);
    if (order.ids.empty()) return tree;
    std::vector<Node>& nodes = tree.bvh.nodes;
    std::vector<std::uint32_t> inner_slots;
    std::vector<Task> tasks{{{0, static_cast<std::uint32_t>(order.ids.size())}, 0}};
    while (!tasks.empty()) {
        const auto [range, slot] = tasks.back();
        tasks.pop_back();
        if (range.size() == 1) {
            nodes[slot] = make_node(order.bounds[range.begin], range.begin, 1);
            continue;
        }
        const std::uint32_t split = split_position(order.codes, range.begin, range.end);
        nodes[slot].first = 2 * split;
        inner_slots.push_back(slot);
        tasks.push_back({{range.begin, split}, 2 * split});
        tasks.push_back({{split, range.end}, 2 * split + 1});
    }
    std::for_each(inner_slots.rbegin(), inner_slots.rend(), [&](std::uint32_t slot) {
        const std::uint32_t first = nodes[slot].first;
        nodes[slot] = make_node(merge(nodes[first].bounds(), nodes[first + 1].bounds()), first, 0);
    });
    return tree;
}

OracleTree hlbvh_tree(const MortonOrder& order) {
    OracleTree tree = lbvh_tree(order);
    std::vector<Node>& nodes = tree.bvh.nodes;
    if (nodes.size() < 6) return tree;
    host::ClusterTop top;
    top.gather(nodes, 0, nodes[0], host::area_limit(nodes, 1.0 / 40));
    if (top.inner.empty()) return tree;
    host::TopWorkspace workspace;
    host::rebuild_top(nodes, top, 0, host::build_by_bins, workspace);
    return tree;
}

OracleTree oracle_tree(std::string_view builder_id, const MortonOrder& order, const BuildOptions& options) {
    const bool exact = builder_id == "ploc" || options.ploc.neighbour_encoding == NeighbourEncoding::bits64;
    const Comparison comparison = exact ? Comparison::exact : Comparison::packed;
    if (builder_id == "ploc" || builder_id == "plocpp") return ploc_tree(order, options.ploc.search_radius, comparison);
    if (builder_id == "plocpp-two-level" && options.ploc.range_count > 0) {
        return two_level_tree(order, options.ploc.search_radius, comparison, options.ploc.range_count);
    }
    if (builder_id == "lbvh") return lbvh_tree(order);
    if (builder_id == "hlbvh") return hlbvh_tree(order);
    if (builder_id == "hploc") return hploc_tree(order, options.hploc);
    throw std::logic_error("no oracle for builder " + std::string(builder_id) + " with these options");
}

}  // namespace clbvh::test
