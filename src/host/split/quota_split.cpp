// Triangle splitting. Karras, Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies",
// section 5.
#include "host/split/quota_split.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "clbvh/core/mesh_bounds.hpp"
#include "core/exact_areas.hpp"
#include "core/prefix_sum.hpp"
#include "host/top_down/sbvh_clip.hpp"

namespace clbvh::host {
namespace {

constexpr std::size_t kChunk = 2048;

/// Both sides of the triangle's projections along the axes: no boxes around parts of it have less surface.
double ideal_surface_of(const MeshView& mesh, const Triangle& triangle) {
    const Vec3 a = mesh.vertex(triangle[0]);
    const Vec3 b = mesh.vertex(triangle[1]);
    const Vec3 c = mesh.vertex(triangle[2]);
    const double ux = double{b.x} - double{a.x}, uy = double{b.y} - double{a.y}, uz = double{b.z} - double{a.z};
    const double vx = double{c.x} - double{a.x}, vy = double{c.y} - double{a.y}, vz = double{c.z} - double{a.z};
    return std::abs(uy * vz - uz * vy) + std::abs(uz * vx - ux * vz) + std::abs(ux * vy - uy * vx);
}

float priority_of(const MeshView& mesh, const MedianGrid& grid, std::size_t triangle) {
    const Aabb box = triangle_bounds(mesh, triangle);
    const auto plane = grid.most_important(box);
    if (!plane) return 0.0f;
    const double surface = 2.0 * exact_half_area(box);
    const double gain = std::max(surface - ideal_surface_of(mesh, mesh.triangle(triangle)), 0.0);
    return static_cast<float>(std::cbrt(std::ldexp(gain, -static_cast<int>(plane->level))));
}

float longest_extent(const Box4& box) {
    const Float4 extents = box.upper - box.lower;
    return std::max({extents.x(), extents.y(), extents.z()});
}

/// Splits a part, and its parts likewise, until `splits` are used up or no plane passes through. Calls
/// `add_part(reference)` for each part that is left. Each level of the grid is met once along each axis, at most.
template <typename AddPart>
void split(const MeshView& mesh, const MedianGrid& grid, const Reference& part, std::uint32_t splits,
           const AddPart& add_part) {
    const auto plane = splits > 0 ? grid.most_important(part.bounds()) : std::nullopt;
    if (!plane) return add_part(part);
    const CutReference cut = cut_reference(&mesh, part, plane->axis, plane->position);
    // The box may reach beyond the plane where the triangle does not.
    if (!has_point(cut.left)) return split(mesh, grid, make_reference(cut.right, part.primitive), splits, add_part);
    if (!has_point(cut.right)) return split(mesh, grid, make_reference(cut.left, part.primitive), splits, add_part);
    const double left_length = longest_extent(cut.left);
    const double both_lengths = left_length + longest_extent(cut.right);
    const double left_share = both_lengths > 0.0 ? left_length / both_lengths : 0.5;
    const auto left_splits = std::min(splits - 1, static_cast<std::uint32_t>(std::lround((splits - 1) * left_share)));
    split(mesh, grid, make_reference(cut.left, part.primitive), left_splits, add_part);
    split(mesh, grid, make_reference(cut.right, part.primitive), splits - 1 - left_splits, add_part);
}

/// Splits the active triangles of a chunk.
template <typename AddPart>
void split_chunk(const MeshView& mesh, const SplitPlan& plan, std::size_t chunk, const AddPart& add_part) {
    const std::size_t end = std::min(mesh.triangle_count, (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
        if (!is_inactive(mesh, i))
            split(mesh, plan.grid(), make_reference(triangle_bounds(mesh, i), static_cast<std::uint32_t>(i)),
                  plan.splits(i), add_part);
    }
}

void write_part(const Reference& reference, std::size_t part, PartBoxes& parts) {
    parts.boxes[part] = reference.bounds();
    parts.source[part] = reference.primitive;
}

}  // namespace

SplitPlan::SplitPlan(const MeshView& mesh, float quota, HostStages& stages)
    : priorities_(mesh.triangle_count), grid_(mesh_bounds(mesh)) {
    const std::uint64_t active = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, mesh.triangle_count, kChunk), std::uint64_t{0},
        [&](const auto& range, std::uint64_t count) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                if (is_inactive(mesh, i)) continue;
                priorities_[i] = priority_of(mesh, grid_, i);
                ++count;
            }
            stages.advance(0);
            return count;
        },
        std::plus<>());
    const auto wanted = static_cast<std::uint64_t>(double{quota} * static_cast<double>(active));
    choose_factor(std::min(wanted, kMaxPrimitives - std::min(active, kMaxPrimitives)));
}

double SplitPlan::sum_priorities() const {
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, priorities_.size(), kChunk), 0.0,
        [&](const auto& range, double sum) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                sum += double{priorities_[i]};
            return sum;
        },
        std::plus<>());
}

std::uint64_t SplitPlan::count_splits(double factor) const {
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, priorities_.size(), 4 * kChunk), std::uint64_t{0},
        [&](const auto& range, std::uint64_t sum) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                sum += static_cast<std::uint64_t>(factor * double{priorities_[i]});
            return sum;
        },
        std::plus<>());
}

// Without rounding, a factor of most_splits / sum would use the quota up, and rounding takes less than one split from
// each triangle: so (most_splits + triangles) / sum is too large. The paper, too, halves a range of factors.
void SplitPlan::choose_factor(std::uint64_t most_splits) {
    constexpr int kHalvings = 20;
    const double sum = sum_priorities();
    if (most_splits == 0 || !(sum > 0.0)) return;
    const auto most = static_cast<double>(most_splits);
    double fitting = 0.0;
    double too_large = (most + static_cast<double>(priorities_.size())) / sum;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (fitting + too_large);
        (count_splits(middle) <= most_splits ? fitting : too_large) = middle;
    }
    factor_ = fitting;
}

void split_to_quota(const MeshView& mesh, float quota, HostStages& stages, PartBoxes& parts) {
    const SplitPlan plan(mesh, quota, stages);
    std::vector<std::size_t> first_parts((mesh.triangle_count + kChunk - 1) / kChunk);
    tbb::parallel_for(std::size_t{0}, first_parts.size(), [&](std::size_t chunk) {
        split_chunk(mesh, plan, chunk, [&](const Reference&) { ++first_parts[chunk]; });
        stages.advance(0);
    });
    const std::size_t part_count = sum_before(std::span(first_parts));
    parts.boxes.resize(part_count);
    parts.source.resize(part_count);
    tbb::parallel_for(std::size_t{0}, first_parts.size(), [&](std::size_t chunk) {
        std::size_t part = first_parts[chunk];
        split_chunk(mesh, plan, chunk, [&](const Reference& reference) { write_part(reference, part++, parts); });
        stages.advance(std::min(mesh.triangle_count - chunk * kChunk, kChunk));
    });
}

}  // namespace clbvh::host
