#pragma once

#include <cstdint>
#include <vector>

#include "device/build/device_algorithm.hpp"
#include "support/oracle/tree_oracle.hpp"

namespace clbvh::test {

/// Result of a cluster stage: every sibling pair but the root's, and the root's reference.
struct ClusterResult {
    std::vector<Node> nodes;           ///< 2 for each leaf; bytes 0xff where the stage wrote nothing.
    std::uint32_t root_reference = 0;  ///< See kernels/core/node.clh.
    BuildStats stats;
};

/// Runs the cluster stage alone on leaves with these boxes and codes.
[[nodiscard]] ClusterResult run_cluster(const device::DeviceAlgorithm& algorithm, const BuildOptions& options,
                                        const MortonOrder& order);
[[nodiscard]] ClusterResult run_cluster(const device::DeviceAlgorithm& algorithm, const device::BuildSettings& settings,
                                        const MortonOrder& order);

/// Runs it for the first of the rounds that the host launches, cancels it, and returns the nodes.
[[nodiscard]] std::vector<Node> run_first_round(const device::DeviceAlgorithm& algorithm, BuildOptions options,
                                                const MortonOrder& order);

/// The nodes after one round of PLOC over `order`, as its definition gives them.
[[nodiscard]] std::vector<Node> first_round_nodes(const MortonOrder& order, std::uint32_t radius,
                                                  Comparison comparison);

/// True where both are the same bytes.
[[nodiscard]] bool same_nodes(const std::vector<Node>& a, const std::vector<Node>& b);

/// Checks that the stage leaves this tree. False where it does not, so that a loop can stop.
bool expect_cluster_tree(const ClusterResult& result, const OracleTree& expected);

/// The order of `count` random triangles.
[[nodiscard]] MortonOrder random_order(std::size_t count);

/// Leaves with these boxes in this order, whatever Morton codes would say.
[[nodiscard]] MortonOrder order_of_boxes(std::vector<Aabb> boxes);

/// `count` points on a line, each gap wider than the one before: the nearest of point i is i - 1, so that only the
/// first two are mutual.
[[nodiscard]] std::vector<Aabb> widening_points(std::size_t count);

}  // namespace clbvh::test
