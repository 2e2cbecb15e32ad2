#include "host/top_down/cluster_top.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <functional>

#include "core/exact_areas.hpp"
#include "core/simd/prefetch.hpp"
#include "host/top_down/binned_sah.hpp"
#include "host/top_down/sweep_sah.hpp"

namespace clbvh::host {
namespace {

double inner_half_area(const Bvh& tree) {
    double sum = exact_half_area(tree.nodes[0]);
    for (std::size_t i = 2; i < tree.nodes.size(); ++i) {
        if (!tree.nodes[i].is_leaf()) sum += exact_half_area(tree.nodes[i]);
    }
    return sum;
}

/// Puts `tree`, whose primitives are `clusters`, in the place of `old`, in the slots that it has.
void write(std::span<Node> nodes, std::span<const ClusterTop::Inner> old, std::span<const Node> clusters,
           const Bvh& tree) {
    struct Place {
        std::uint32_t slot;  // in `nodes`,
        std::uint32_t node;  // of what of `tree`
    };
    std::vector<Place> stack{{old[0].slot, 0}};
    std::size_t pairs_used = 0;
    while (!stack.empty()) {
        const Place place = stack.back();
        stack.pop_back();
        Node node = tree.nodes[place.node];
        if (node.is_leaf()) {
            nodes[place.slot] = clusters[tree.primitive_ids[node.first]];
            continue;
        }
        const std::uint32_t pair = old[pairs_used++].pair;
        stack.insert(stack.end(), {{pair + 1, node.first + 1}, {pair, node.first}});
        node.first = pair;
        nodes[place.slot] = node;
    }
}

}  // namespace

float area_limit(std::span<const Node> nodes, double share) {
    constexpr std::size_t kSamples = 4096;
    constexpr double kLeastNodes = 1024.0;
    const std::size_t pairs = nodes.size() / 2 - 1;  // but the root's
    const std::size_t samples = std::min(pairs, kSamples);
    std::vector<float> areas;
    areas.reserve(samples);
    for (std::size_t i = 0; i < samples; ++i) {
        const Node* const pair = &nodes[2 * (1 + i * pairs / samples)];
        const float area = half_area(merge(pair[0].bounds(), pair[1].bounds()));
        // Slots that no node uses are mostly zeros; whatever else they hold may be counted, but for NaNs.
        const bool is_used = pair[0].first != pair[1].first && area >= 0.0f;
        if (is_used) areas.push_back(area);
    }
    const double part = std::max(share, std::min(kLeastNodes / static_cast<double>(pairs), 1.0));
    const auto rank = static_cast<std::size_t>(part * static_cast<double>(areas.size()));
    if (rank >= areas.size()) return -1.0f;
    const auto limit = areas.begin() + static_cast<std::ptrdiff_t>(rank);
    std::ranges::nth_element(areas, limit, std::greater());
    return *limit;
}

void ClusterTop::gather(std::span<const Node> nodes, std::uint32_t slot, const Node& root, float limit) {
    struct Waiting {
        std::uint32_t slot;
        Node node;
    };
    const auto is_inner = [&](const Node& node) { return !node.is_leaf() && half_area(node.bounds()) > limit; };
    inner.clear();
    clusters.clear();
    // Level by level first, so that many pairs are on their way from memory at any time.
    level_order_.clear();
    if (is_inner(root)) level_order_.push_back(root.first);
    for (std::size_t i = 0; i < level_order_.size(); ++i) {
        for (const Node& node : nodes.subspan(level_order_[i], 2)) {
            if (!is_inner(node)) continue;
            prefetch(&nodes[node.first]);
            level_order_.push_back(node.first);
        }
    }
    std::vector<Waiting> stack{{slot, root}};
    while (!stack.empty()) {
        const auto [place, node] = stack.back();
        stack.pop_back();
        if (!is_inner(node)) {
            clusters.push_back(node);
            continue;
        }
        const auto before = static_cast<std::uint32_t>(clusters.size());
        inner.push_back({exact_half_area(node), place, node.first, before, 0});
        for (const std::uint32_t child : {node.first + 1, node.first})
            stack.push_back({child, nodes[child]});
    }
    count_clusters();
}

std::array<std::uint32_t, 2> ClusterTop::children(std::uint32_t i) const noexcept {
    const auto at = [&](std::uint32_t child, std::uint32_t slot) {
        return child < inner.size() && inner[child].slot == slot ? child : kCluster;
    };
    const std::uint32_t left = at(i + 1, inner[i].pair);
    const std::uint32_t left_count = left == kCluster ? 1 : inner[left].cluster_count;
    return {left, at(i + left_count, inner[i].pair + 1)};
}

void ClusterTop::count_clusters() noexcept {
    for (auto i = static_cast<std::uint32_t>(inner.size()); i-- > 0;) {
        for (const std::uint32_t child : children(i))
            inner[i].cluster_count += child == kCluster ? 1 : inner[child].cluster_count;
    }
}

void build_by_bins(std::span<const Aabb> boxes, Scratch& scratch, Bvh& result) {
    BinnedSahConfig config;
    config.max_leaf_size = 1;
    build_binned_sah(boxes, config, scratch, result);
}

void build_by_sweep(std::span<const Aabb> boxes, Scratch& scratch, Bvh& result) {
    SweepSahConfig config;
    config.max_leaf_size = 1;
    build_sweep_sah(boxes, config, scratch, result);
}

double rebuild_top(std::span<Node> nodes, const ClusterTop& top, std::uint32_t inner, BoxBuilder builder,
                   TopWorkspace& workspace) {
    const std::uint32_t count = top.inner[inner].cluster_count;
    const auto old = std::span(top.inner).subspan(inner, count - 1);
    const auto clusters = std::span(top.clusters).subspan(top.inner[inner].first_cluster, count);
    workspace.boxes.resize(count);
    std::ranges::transform(clusters, workspace.boxes.begin(), &Node::bounds);
    // Isolated: a thread that waits for its own build must not take up another one in the same workspace.
    tbb::this_task_arena::isolate([&] { builder(workspace.boxes, workspace.scratch, workspace.tree); });
    double old_area = 0.0;
    for (const ClusterTop::Inner& node : old)
        old_area += node.half_area;
    const double area = inner_half_area(workspace.tree);
    // The two sums add in different orders, and so differ by rounding where the trees are the same.
    if (!(area < old_area * (1.0 - 1e-12))) return 0.0;
    write(nodes, old, clusters, workspace.tree);
    return old_area - area;
}

}  // namespace clbvh::host
