#include "clbvh/metrics/surface_ray_cost.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/trace/traverse.hpp"
#include "core/check_field.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "layout/check_tree.hpp"
#include "metrics/check_costs.hpp"
#include "metrics/surface_rays.hpp"
#include "metrics/triangle_surface.hpp"
#include "trace/leaf_triangles.hpp"

namespace clbvh {
namespace {

using trace::HitRule;
using trace::TriangleVertices;
using trace::WatertightTest;

/// Five coordinates in [0, 1).
using SequencePoint = std::array<double, 5>;

/// Of Roberts' sequence R5: multiples of the powers of 1 / g, g^6 = g + 1.
SequencePoint point_of_sequence(std::uint32_t index) noexcept {
    constexpr double inverse = 1.0 / 1.16730397826141868;
    SequencePoint point;
    double step = 1.0;
    for (double& coordinate : point) {
        step *= inverse;
        const double at = 0.5 + step * (index + 1.0);
        coordinate = at - std::floor(at);
    }
    return point;
}

/// Chooses triangles by area. The sums are over blocks, and of a block only where it is chosen.
class TrianglesByArea {
public:
    explicit TrianglesByArea(const MeshView& mesh)
        : mesh_(mesh), sums_((std::size_t{mesh.triangle_count} + kBlock - 1) / kBlock) {
        tbb::parallel_for(std::size_t{0}, sums_.size(), [&](std::size_t block) {
            for (std::size_t triangle = block * kBlock; triangle < end_of(block); ++triangle)
                sums_[block] += area_of(triangle);
        });
        for (std::size_t block = 1; block < sums_.size(); ++block)
            sums_[block] += sums_[block - 1];
    }

    /// At the part `at` of all area, in [0, 1); a triangle of no area where none has any.
    [[nodiscard]] std::uint32_t choose(double at) const noexcept {
        const double wanted = at * sums_.back();
        const auto found = std::ranges::upper_bound(sums_, wanted);
        const auto block = static_cast<std::size_t>(std::min(found, sums_.end() - 1) - sums_.begin());
        double sum = block > 0 ? sums_[block - 1] : 0.0;
        std::size_t last = block * kBlock;
        for (std::size_t triangle = last; triangle < end_of(block) && sum <= wanted; ++triangle) {
            const double area = area_of(triangle);
            if (area == 0.0) continue;
            last = triangle;
            sum += area;
        }
        return static_cast<std::uint32_t>(last);
    }

private:
    static constexpr std::size_t kBlock = 256;

    [[nodiscard]] std::size_t end_of(std::size_t block) const noexcept {
        return std::min<std::size_t>((block + 1) * kBlock, mesh_.triangle_count);
    }
    [[nodiscard]] double area_of(std::size_t triangle) const noexcept {
        // An inactive triangle has a NaN, and so has its area.
        const double area = TriangleSurface(mesh_, static_cast<std::uint32_t>(triangle)).area();
        return area > 0.0 ? area : 0.0;
    }

    const MeshView& mesh_;
    std::vector<double> sums_;  ///< Of all areas up to and with the block's.
};

TriangleVertices vertices_of(const MeshView& mesh, std::uint32_t triangle) noexcept {
    const Triangle corners = mesh.triangle(triangle);
    return {mesh.vertex(corners[0]), mesh.vertex(corners[1]), mesh.vertex(corners[2])};
}

Ray ray_from(const TriangleSurface& surface, const SequencePoint& at) noexcept {
    double u = at[1], v = at[2];
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    const Point point = surface.at(u, v);
    const double z = 1.0 - 2.0 * at[3];
    const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double angle = 2.0 * std::numbers::pi * at[4];
    Ray ray;
    ray.origin = {static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])};
    ray.direction = {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle)),
                     static_cast<float>(z)};
    // As renderers have it: boxes that the ray leaves at once do not count, those of flat things among them.
    const Aabb& box = surface.bounds();
    const Vec3 reach = max(max(box.upper, -box.upper), max(box.lower, -box.lower));
    ray.t_min = 0x1p-18f * std::max({reach.x, reach.y, reach.z});
    return ray;
}

/// Ends a ray at its closest hit with any triangle but the one that it begins on.
class EndAtHit {
public:
    EndAtHit(const MeshView& mesh, std::span<const std::uint32_t> ids, const Ray& ray, std::uint32_t own) noexcept
        : mesh_(mesh), ids_(ids), rule_(ray), test_(ray), own_(own) {}

    bool operator()(std::uint32_t first, std::uint32_t count, float& t_max) noexcept {
        tested_ += count;
        for (const std::uint32_t id : ids_.subspan(first, count)) {
            if (id == own_) continue;
            const TriangleVertices triangle = vertices_of(mesh_, id);
            const auto hit = rule_.accept(triangle, test_.meet(triangle));
            if (hit && hit->t < t_max) t_max = hit->t;
        }
        return true;
    }

    [[nodiscard]] std::uint32_t tested() const noexcept { return tested_; }

private:
    const MeshView& mesh_;
    std::span<const std::uint32_t> ids_;
    HitRule rule_;
    WatertightTest test_;
    std::uint32_t own_;
    std::uint32_t tested_ = 0;
};

struct Sums {
    std::uint64_t rays = 0, inner_nodes = 0, leaves = 0, triangles = 0;

    friend Sums operator+(const Sums& a, const Sums& b) noexcept {
        return {a.rays + b.rays, a.inner_nodes + b.inner_nodes, a.leaves + b.leaves, a.triangles + b.triangles};
    }
};

/// Traces the rays of the sample through one tree.
class Sample {
public:
    Sample(std::span<const Node> nodes, std::span<const std::uint32_t> ids, const MeshView& mesh)
        : nodes_(nodes), ids_(ids), mesh_(mesh), by_area_(mesh) {}

    void add(std::uint32_t index, Sums& sums) const {
        const SequencePoint at = point_of_sequence(index);
        const std::uint32_t triangle = index % 2 == 0 ? nth_part(at[0]) : by_area_.choose(at[0]);
        if (is_inactive(mesh_, triangle)) return;
        const TriangleSurface surface(mesh_, triangle);
        if (surface.area() == 0.0) return;
        const Ray ray = ray_from(surface, at);
        EndAtHit leaf(mesh_, ids_, ray, triangle);
        RayCounts counts;
        traverse(nodes_, ray, leaf, counts);
        sums = sums + Sums{1, counts.inner_nodes, counts.leaves, leaf.tested()};
    }

private:
    [[nodiscard]] std::uint32_t nth_part(double at) const noexcept {
        return static_cast<std::uint32_t>(at * static_cast<double>(mesh_.triangle_count));
    }

    std::span<const Node> nodes_;
    std::span<const std::uint32_t> ids_;
    const MeshView& mesh_;
    TrianglesByArea by_area_;
};

}  // namespace

SurfaceRayCost trace_surface_rays(std::span<const Node> nodes, std::span<const std::uint32_t> primitive_ids,
                                  const MeshView& mesh, std::uint32_t ray_count, const SahCosts& costs) {
    if (nodes.empty()) return {};
    const Sample sample(nodes, primitive_ids, mesh);
    const auto add_range = [&](const tbb::blocked_range<std::uint32_t>& range, Sums sums) {
        for (std::uint32_t i = range.begin(); i < range.end(); ++i)
            sample.add(i, sums);
        return sums;
    };
    const Sums sums = tbb::parallel_reduce(tbb::blocked_range<std::uint32_t>(0, ray_count, 64), Sums{}, add_range,
                                           [](const Sums& a, const Sums& b) { return a + b; });
    SurfaceRayCost result;
    result.ray_count = static_cast<std::uint32_t>(sums.rays);
    if (sums.rays == 0) return result;
    const auto mean = [&](std::uint64_t sum) { return static_cast<double>(sum) / static_cast<double>(sums.rays); };
    result.counts = {mean(sums.inner_nodes), mean(sums.leaves), mean(sums.triangles)};
    result.cost = costs.inner * result.counts.inner_nodes + costs.primitive * result.counts.triangles;
    return result;
}

SurfaceRayCost surface_ray_cost(const Bvh& bvh, const MeshView& mesh, std::uint32_t ray_count, const SahCosts& costs) {
    check_costs(costs);
    check_range("ray_count", ray_count, 1, kMostSurfaceRays);
    static_cast<void>(check_mesh(mesh));
    return with_memory_errors("rays from surfaces", [&] {
        return in_own_group([&] {
            layout::check_tree(bvh, mesh);
            return trace_surface_rays(bvh.nodes, bvh.primitive_ids, mesh, ray_count, costs);
        });
    });
}

}  // namespace clbvh
