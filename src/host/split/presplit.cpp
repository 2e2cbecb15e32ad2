// Edge volume heuristic. Dammertz, Keller 2008, "The edge volume heuristic - robust triangle subdivision for improved
// BVH performance".
//
// Parts are counted first, by chunks of triangles, then written to where they belong. The paper has no bound on their
// number; here the threshold is raised for the whole mesh until they fit, because a bound for single triangles would
// split an edge on one of its sides only.
#include "host/split/presplit.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>

#include "clbvh/core/mesh_bounds.hpp"
#include "core/check_field.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/prefix_sum.hpp"
#include "host/split/config_rules.hpp"
#include "host/top_down/subdivision.hpp"

namespace clbvh::host {
namespace {

constexpr std::size_t kChunk = 512;

double volume_of(const Aabb& box) {
    return (double{box.upper.x} - double{box.lower.x}) * (double{box.upper.y} - double{box.lower.y}) *
           (double{box.upper.z} - double{box.lower.z});
}

/// Counts parts up to a limit.
struct CountingSink {
    std::uint64_t limit;
    std::uint64_t count = 0;

    static std::uint32_t add_vertex(const Corner&) noexcept { return 0; }
    bool add_part(const Corners&) noexcept { return ++count <= limit; }
};

/// Decides how far to split, and where the parts of each chunk of triangles go.
class Plan {
public:
    Plan(const MeshView& mesh, const PresplitConfig& config, bool keeps_inactive, HostStages& stages)
        : mesh_(mesh), keeps_inactive_(keeps_inactive), stages_(stages), first_parts_(chunk_count() + 1) {
        const double scene_volume = volume_of(mesh_bounds(mesh));
        const std::uint64_t limit = most_parts(config.triangle_budget);
        const auto threshold_of = [&](std::uint32_t level) {
            return std::ldexp(scene_volume, -static_cast<int>(level));
        };
        // Fewer levels, fewer parts: bisection. At level 0, no edge is above the threshold.
        std::uint32_t fitting = 0;
        std::uint32_t most = config.level;
        std::uint32_t counted = most;
        while (fitting < most) {
            if (count_parts(threshold_of(counted), limit)) {
                fitting = counted;
            } else {
                most = counted - 1;
            }
            if (fitting < most) counted = fitting + (most - fitting + 1) / 2;
        }
        threshold_ = threshold_of(fitting);
        if (counted != fitting) static_cast<void>(count_parts(threshold_, limit));
        sum_before(std::span(first_parts_));
    }

    [[nodiscard]] double threshold() const noexcept { return threshold_; }
    [[nodiscard]] std::size_t part_count() const noexcept { return first_parts_.back(); }

    /// Calls `write(triangle, first_part)` for each triangle that has parts, in parallel; it returns their number.
    template <typename Write>
    void for_each_triangle(const Write& write) const {
        tbb::parallel_for(std::size_t{0}, chunk_count(), [&](std::size_t chunk) {
            std::size_t part = first_parts_[chunk];
            for (std::size_t i = chunk * kChunk; i < end_of(chunk); ++i) {
                if (keeps_inactive_ || !is_inactive(mesh_, i)) part += write(i, part);
            }
            stages_.advance(end_of(chunk) - chunk * kChunk);
        });
    }

private:
    [[nodiscard]] std::size_t chunk_count() const noexcept { return (mesh_.triangle_count + kChunk - 1) / kChunk; }
    [[nodiscard]] std::size_t end_of(std::size_t chunk) const noexcept {
        return std::min(mesh_.triangle_count, (chunk + 1) * kChunk);
    }

    /// Never below the number of triangles; ids of parts and of new vertices stay in range.
    [[nodiscard]] std::uint64_t most_parts(float budget) const {
        const std::uint64_t count = mesh_.triangle_count;
        const auto allowed = static_cast<std::uint64_t>(double{budget} * static_cast<double>(count));
        const std::uint64_t indices = std::numeric_limits<std::uint32_t>::max();
        const std::uint64_t spare = indices - std::min<std::uint64_t>(mesh_.vertex_count, indices);
        return std::min({allowed, count + spare, std::max(count, kMaxPrimitives)});
    }

    /// Counts the parts of each chunk. False where they are more than `limit`; then it has stopped early.
    bool count_parts(double threshold, std::uint64_t limit) {
        std::atomic<std::uint64_t> total = 0;
        tbb::parallel_for(std::size_t{0}, chunk_count(), [&](std::size_t chunk) {
            if (total.load(std::memory_order_relaxed) > limit) return;
            CountingSink sink{limit};
            bool fits = true;
            for (std::size_t i = chunk * kChunk; fits && i < end_of(chunk); ++i) {
                if (!is_inactive(mesh_, i)) {
                    fits = subdivide(corners_of(mesh_, mesh_.triangle(i)), threshold, sink);
                } else if (keeps_inactive_) {
                    ++sink.count;
                }
            }
            first_parts_[chunk] = sink.count;
            total.fetch_add(fits ? sink.count : limit + 1, std::memory_order_relaxed);
            stages_.advance(0);
        });
        return total <= limit;
    }

    const MeshView& mesh_;
    bool keeps_inactive_;
    HostStages& stages_;
    double threshold_ = 0.0;
    std::vector<std::size_t> first_parts_;  // of each chunk, and one behind the last
};

/// Writes parts into a mesh; new vertices follow the old ones, one a split.
struct MeshSink {
    Mesh& mesh;
    std::size_t part;
    std::uint32_t vertex;

    std::uint32_t add_vertex(const Corner& corner) {
        mesh.vertices[vertex] = {static_cast<float>(corner.x), static_cast<float>(corner.y),
                                 static_cast<float>(corner.z)};
        return vertex++;
    }
    bool add_part(const Corners& corners) {
        mesh.triangles[part++] = {corners[0].vertex, corners[1].vertex, corners[2].vertex};
        return true;
    }
};

/// Bound on the rounding error of at most kMaxSplitDepth midpoints, relative to the largest coordinate.
constexpr double kMidpointError = kMaxSplitDepth * 0x1p-52;

/// One axis of a part's box: rounded outwards, within the triangle's.
struct Interval {
    float lower;
    float upper;
};
Interval bound_outwards(double a, double b, double c, float lower, float upper) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const double slack = kMidpointError * std::max(std::abs(double{lower}), std::abs(double{upper}));
    const double least = std::min({a, b, c}) - slack;
    const double most = std::max({a, b, c}) + slack;
    Interval part{static_cast<float>(least), static_cast<float>(most)};
    if (double{part.lower} > least) part.lower = std::nextafter(part.lower, -infinity);
    if (double{part.upper} < most) part.upper = std::nextafter(part.upper, infinity);
    return {std::max(part.lower, lower), std::min(part.upper, upper)};
}

/// Writes parts as boxes.
struct BoxSink {
    std::span<Aabb> boxes;
    std::size_t part;
    Aabb whole;  ///< Box of the triangle.

    static std::uint32_t add_vertex(const Corner&) noexcept { return 0; }
    bool add_part(const Corners& corners) {
        const auto& [a, b, c] = corners;
        const Interval x = bound_outwards(a.x, b.x, c.x, whole.lower.x, whole.upper.x);
        const Interval y = bound_outwards(a.y, b.y, c.y, whole.lower.y, whole.upper.y);
        const Interval z = bound_outwards(a.z, b.z, c.z, whole.lower.z, whole.upper.z);
        boxes[part++] = {{x.lower, y.lower, z.lower}, {x.upper, y.upper, z.upper}};
        return true;
    }
};

}  // namespace

void presplit(const MeshView& mesh, const PresplitConfig& config, HostStages& stages, PartBoxes& parts) {
    const Plan plan(mesh, config, false, stages);
    parts.boxes.resize(plan.part_count());
    parts.source.resize(plan.part_count());
    plan.for_each_triangle([&](std::size_t triangle, std::size_t first_part) {
        BoxSink sink{parts.boxes, first_part, triangle_bounds(mesh, triangle)};
        subdivide(corners_of(mesh, mesh.triangle(triangle)), plan.threshold(), sink);
        std::fill(parts.source.begin() + static_cast<std::ptrdiff_t>(first_part),
                  parts.source.begin() + static_cast<std::ptrdiff_t>(sink.part), static_cast<std::uint32_t>(triangle));
        return sink.part - first_part;
    });
}

}  // namespace clbvh::host

namespace clbvh {

namespace host {
namespace {

PresplitMesh split(const MeshView& mesh, const PresplitConfig& config) {
    const ProgressCallback no_progress;
    HostStages stages(no_progress);
    const Plan plan(mesh, config, true, stages);
    const std::size_t old_vertices = mesh.vertex_count;
    PresplitMesh result;
    result.mesh.vertices.resize(old_vertices + plan.part_count() - mesh.triangle_count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, old_vertices, 16 * kChunk), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            result.mesh.vertices[i] = mesh.vertex(i);
    });
    result.mesh.triangles.resize(plan.part_count());
    result.source.resize(plan.part_count());
    plan.for_each_triangle([&](std::size_t triangle, std::size_t first_part) {
        MeshSink sink{result.mesh, first_part, static_cast<std::uint32_t>(old_vertices + first_part - triangle)};
        if (is_inactive(mesh, triangle)) {
            result.mesh.triangles[sink.part++] = mesh.triangle(triangle);
        } else {
            subdivide(corners_of(mesh, mesh.triangle(triangle)), plan.threshold(), sink);
        }
        std::fill(result.source.begin() + static_cast<std::ptrdiff_t>(first_part),
                  result.source.begin() + static_cast<std::ptrdiff_t>(sink.part), static_cast<std::uint32_t>(triangle));
        return sink.part - first_part;
    });
    return result;
}

}  // namespace
}  // namespace host

PresplitMesh presplit(const MeshView& mesh, const PresplitConfig& config) {
    check_range("level", config.level, 1, host::kMaxPresplitLevel);
    check_range("triangle_budget", config.triangle_budget, 1.0f, 64.0f);
    static_cast<void>(check_mesh(mesh));
    return with_memory_errors("the split mesh",
                              [&] { return in_own_group([&] { return host::split(mesh, config); }); });
}

}  // namespace clbvh
