// Leaf count variability. Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", equation 4.
#include "clbvh/metrics/lcv.hpp"

#include <cmath>

namespace clbvh {

MeanCounts mean_counts(std::span<const RayCounts> rays) {
    if (rays.empty()) return {};
    std::uint64_t inner_nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t triangles = 0;
    for (const RayCounts& ray : rays) {
        inner_nodes += ray.inner_nodes;
        leaves += ray.leaves;
        triangles += ray.triangles;
    }
    const auto count = static_cast<double>(rays.size());
    return {static_cast<double>(inner_nodes) / count, static_cast<double>(leaves) / count,
            static_cast<double>(triangles) / count};
}

double leaf_count_variability(std::span<const RayCounts> rays) {
    if (rays.empty()) return 0.0;
    // Equation 4 subtracts two large numbers; the deviations from the mean are the same, and round less.
    const double mean = mean_counts(rays).leaves;
    double sum = 0.0;
    for (const RayCounts& ray : rays)
        sum += (ray.leaves - mean) * (ray.leaves - mean);
    return std::sqrt(sum / static_cast<double>(rays.size()));
}

}  // namespace clbvh
