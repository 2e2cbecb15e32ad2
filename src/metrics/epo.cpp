// End-point overlap. Aila, Karras, Laine 2013, "On Quality Metrics of Bounding Volume Hierarchies", equation 3. The sum
// over nodes is turned around: each triangle goes down the tree, and what it adds to all nodes is summed up.
#include "clbvh/metrics/epo.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/box_overlap.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "metrics/check_costs.hpp"
#include "metrics/leaf_order.hpp"
#include "metrics/node_cost.hpp"
#include "metrics/subtree_sums.hpp"
#include "metrics/triangle_surface.hpp"

namespace clbvh {
namespace {

/// References that one sum is over. Sums are added in their order, so that the total is the same on any number of
/// threads.
constexpr std::size_t kChunk = 256;

/// How often progress is told: parts of the whole.
constexpr std::size_t kRounds = 64;

/// Areas times costs, and areas.
struct Sums {
    double extra = 0.0;
    double area = 0.0;
};

class OverlapSum {
public:
    OverlapSum(const Bvh& bvh, const MeshView& mesh, const SahCosts& costs)
        : bvh_(bvh), mesh_(mesh), costs_(costs), order_(bvh, mesh.triangle_count), sums_(bvh, order_, costs) {}

    [[nodiscard]] std::size_t chunk_count() const { return (order_.reference_count() + kChunk - 1) / kChunk; }

    /// Of the triangles whose first reference is in the chunk: neighbours there are neighbours in the scene, and meet
    /// the same nodes.
    [[nodiscard]] Sums of_chunk(std::size_t chunk) const {
        Sums sums;
        std::vector<std::uint32_t> stack;
        const std::size_t end = std::min((chunk + 1) * kChunk, order_.reference_count());
        for (std::size_t reference = chunk * kChunk; reference < end; ++reference) {
            const std::uint32_t triangle = order_.triangle(reference);
            if (order_.references(triangle).front() != reference || is_inactive(mesh_, triangle)) continue;
            const TriangleSurface surface(mesh_, triangle);
            sums.area += surface.area();
            if (surface.area() > 0.0) sums.extra += extra_of(surface, order_.references(triangle), stack);
        }
        return sums;
    }

private:
    /// The areas of the triangle in the nodes that it does not belong to, each times the node's cost.
    [[nodiscard]] double extra_of(const TriangleSurface& surface, std::span<const std::uint32_t> references,
                                  std::vector<std::uint32_t>& stack) const {
        double extra = 0.0;
        stack.assign(1, 0);
        while (!stack.empty()) {
            const std::uint32_t index = stack.back();
            stack.pop_back();
            const Node& node = bvh_.nodes[index];
            if (!touch(node.bounds(), surface.bounds())) continue;
            if (!has_one_in(references, order_.below(index))) {
                if (is_within(surface.bounds(), sums_.core(index))) {
                    extra += sums_.cost(index) * surface.area();
                    continue;
                }
                const double area = surface.area_within(node.bounds());
                if (area == 0.0) continue;  // and none in any box within this one
                extra += node_cost(node, costs_) * area;
            }
            if (node.is_leaf()) continue;
            stack.push_back(node.first + 1);
            stack.push_back(node.first);
        }
        return extra;
    }

    const Bvh& bvh_;
    MeshView mesh_;
    SahCosts costs_;
    LeafOrder order_;
    SubtreeSums sums_;
};

void tell(const ProgressCallback& progress, double fraction) {
    if (progress && !progress({"epo", fraction})) throw Error(ErrorCode::cancelled, "the progress callback cancelled");
}

double overlap_of(const Bvh& bvh, const MeshView& mesh, const SahCosts& costs, const ProgressCallback& progress) {
    const OverlapSum overlap(bvh, mesh, costs);
    std::vector<Sums> sums(overlap.chunk_count());
    const std::size_t step = progress ? std::max<std::size_t>(1, sums.size() / kRounds) : sums.size();
    for (std::size_t begin = 0; begin < sums.size(); begin += step) {
        tell(progress, static_cast<double>(begin) / static_cast<double>(sums.size()));
        tbb::parallel_for(begin, std::min(begin + step, sums.size()),
                          [&](std::size_t chunk) { sums[chunk] = overlap.of_chunk(chunk); });
    }
    Sums total;
    for (const Sums& part : sums) {
        total.extra += part.extra;
        total.area += part.area;
    }
    tell(progress, 1.0);
    return total.area > 0.0 ? total.extra / total.area : 0.0;
}

}  // namespace

double end_point_overlap(const Bvh& bvh, const MeshView& mesh, const SahCosts& costs,
                         const ProgressCallback& progress) {
    check_costs(costs);
    static_cast<void>(check_mesh(mesh));
    return with_memory_errors("end-point overlap",
                              [&] { return in_own_group([&] { return overlap_of(bvh, mesh, costs, progress); }); });
}

}  // namespace clbvh
