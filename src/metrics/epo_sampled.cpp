// Equation 3 of Aila, Karras, Laine 2013 as the expectation that it is: points are drawn from the surfaces, and each
// looks up the nodes that it lies in.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/metrics/epo.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/random.hpp"
#include "metrics/check_costs.hpp"
#include "metrics/leaf_order.hpp"
#include "metrics/node_cost.hpp"
#include "metrics/subtree_sums.hpp"
#include "metrics/triangle_surface.hpp"

namespace clbvh {
namespace {

/// Samples that one generator of random numbers is for. Its numbers depend on the seed and its place alone.
constexpr std::uint64_t kChunk = 1024;

/// Uniform in [0, 1), with all bits that a double has: there are more triangles than floats.
double unit(Random& random) {
    return static_cast<double>(random.bits() >> 11) * 0x1p-53;
}

bool contains(const Aabb& box, const Point& point) {
    return box.lower.x <= point[0] && point[0] <= box.upper.x && box.lower.y <= point[1] && point[1] <= box.upper.y &&
           box.lower.z <= point[2] && point[2] <= box.upper.z;
}

/// Sums over samples.
struct Moments {
    double sum = 0.0;
    double sum_of_squares = 0.0;
};

class Sampler {
public:
    Sampler(const Bvh& bvh, const MeshView& mesh, const SahCosts& costs)
        : bvh_(bvh), mesh_(mesh), costs_(costs), order_(bvh, mesh.triangle_count), sums_(bvh, order_, costs) {
        double area = 0.0;
        areas_.reserve(order_.reference_count());
        for (std::size_t reference = 0; reference < order_.reference_count(); ++reference) {
            const std::uint32_t triangle = order_.triangle(reference);
            const bool is_first = order_.references(triangle).front() == reference;
            if (is_first && !is_inactive(mesh, triangle)) area += TriangleSurface(mesh, triangle).area();
            areas_.push_back(area);
        }
    }

    [[nodiscard]] bool has_surface() const { return !areas_.empty() && areas_.back() > 0.0; }

    /// Of `count` samples.
    [[nodiscard]] Moments sample(Random random, std::uint64_t count) const {
        Moments moments;
        std::vector<std::uint32_t> stack;
        for (std::uint64_t i = 0; i < count; ++i) {
            const double cost = sample_cost(random, stack);
            moments.sum += cost;
            moments.sum_of_squares += cost * cost;
        }
        return moments;
    }

private:
    /// The cost of the nodes around one point whose triangle does not belong to them.
    [[nodiscard]] double sample_cost(Random& random, std::vector<std::uint32_t>& stack) const {
        // The first reference whose sum of areas is above the number: one with an area.
        const auto chosen = std::ranges::upper_bound(areas_, unit(random) * areas_.back());
        const auto reference = static_cast<std::size_t>(std::min(chosen, areas_.end() - 1) - areas_.begin());
        const std::uint32_t triangle = order_.triangle(reference);
        double u = unit(random);
        double v = unit(random);
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        return cost_at(TriangleSurface(mesh_, triangle).at(u, v), order_.references(triangle), stack);
    }

    [[nodiscard]] double cost_at(const Point& point, std::span<const std::uint32_t> references,
                                 std::vector<std::uint32_t>& stack) const {
        double cost = 0.0;
        stack.assign(1, 0);
        while (!stack.empty()) {
            const std::uint32_t index = stack.back();
            stack.pop_back();
            const Node& node = bvh_.nodes[index];
            if (!contains(node.bounds(), point)) continue;
            if (!has_one_in(references, order_.below(index))) {
                if (contains(sums_.core(index), point)) {
                    cost += sums_.cost(index);
                    continue;
                }
                cost += node_cost(node, costs_);
            }
            if (node.is_leaf()) continue;
            stack.push_back(node.first + 1);
            stack.push_back(node.first);
        }
        return cost;
    }

    const Bvh& bvh_;
    MeshView mesh_;
    SahCosts costs_;
    LeafOrder order_;
    SubtreeSums sums_;
    std::vector<double> areas_;  ///< Of all triangles up to and with the one of each reference.
};

Estimate estimate_from(const Moments& moments, double count) {
    const double mean = moments.sum / count;
    const double variance = std::max(0.0, moments.sum_of_squares / count - mean * mean) * count / (count - 1.0);
    return {mean, std::sqrt(variance / count)};
}

}  // namespace

Estimate end_point_overlap_sampled(const Bvh& bvh, const MeshView& mesh, std::uint64_t samples, std::uint64_t seed,
                                   const SahCosts& costs) {
    check_costs(costs);
    if (samples < kFewestEpoSamples || samples > kMostEpoSamples) {
        throw Error(ErrorCode::invalid_input, std::to_string(samples) + " samples cannot make an estimate: take " +
                                                  std::to_string(kFewestEpoSamples) + " to " +
                                                  std::to_string(kMostEpoSamples));
    }
    static_cast<void>(check_mesh(mesh));
    const auto estimate = [&]() -> Estimate {
        const Sampler sampler(bvh, mesh, costs);
        if (!sampler.has_surface()) return {};
        std::vector<Moments> parts((samples + kChunk - 1) / kChunk);
        tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t chunk) {
            parts[chunk] = sampler.sample(Random::stream(seed, chunk), std::min(kChunk, samples - chunk * kChunk));
        });
        Moments total;
        for (const Moments& part : parts) {
            total.sum += part.sum;
            total.sum_of_squares += part.sum_of_squares;
        }
        return estimate_from(total, static_cast<double>(samples));
    };
    return with_memory_errors("end-point overlap", [&] { return in_own_group(estimate); });
}

}  // namespace clbvh
