#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// How a Tracer traces.
struct TracerOptions {
    TriangleTest triangle_test = TriangleTest::watertight;
    std::uint32_t thread_count = 0;  ///< Threads of the calls for many rays, 1 to 1024; 0: all.
};

/// Traces rays on the host through a tree over a triangle mesh. Keeps a copy of all it needs: tree and mesh may go.
/// Any number of threads may use it at a time.
///
/// The closest hit is the one with the smallest t, and among equal ones the smallest primitive. What rounding puts
/// before a triangle's own box counts from where the ray enters that box, and a ray that misses the box misses the
/// triangle: so the closest hit is the same bits with every tree, as long as its boxes contain whole triangles (with
/// split ones, hits whose t is rounded by more than 2^-18 may go another way). Triangles have no back: both sides are
/// hit. Where coordinates relative to the ray's origin exceed about 1e12, products overflow and triangles are missed.
class CLBVH_API Tracer {
public:
    /// Throws Error(invalid_input) where the tree was not built over this mesh: nodes, ids or indices out of range, or
    /// loops.
    Tracer(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options = {});
    Tracer(const Tracer&) = delete;
    Tracer(Tracer&&) noexcept;
    Tracer& operator=(const Tracer&) = delete;
    Tracer& operator=(Tracer&&) noexcept;
    ~Tracer();

    [[nodiscard]] Hit closest(const Ray& ray) const;  ///< The first hit along the ray.
    [[nodiscard]] bool any(const Ray& ray) const;     ///< Whether there is a hit at all; stops at the first one found.
    /// The same hit, and what it cost: added to `counts`.
    [[nodiscard]] Hit closest(const Ray& ray, RayCounts& counts) const;
    [[nodiscard]] bool any(const Ray& ray, RayCounts& counts) const;
    /// Calls `visit` with every hit, ordered by t and then by primitive, until it returns false.
    void all(const Ray& ray, const std::function<bool(const Hit&)>& visit) const;

    /// The nodes and triangles that the ray would visit if no hit ended it: every inner node and leaf whose box it
    /// meets up to t_max, and their triangles. Over random lines through the root's box these add up to the SAH cost.
    [[nodiscard]] RayCounts visits(const Ray& ray) const;

    /// Many rays at a time, in parallel; hits[i] is that of rays[i]. Throws Error(invalid_input) where the spans differ
    /// in length.
    void closest(std::span<const Ray> rays, std::span<Hit> hits) const;
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) const;  ///< 1 or 0 each.
    /// The same with what each ray cost; counts[i] is set, not added to.
    void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) const;
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) const;
    void visits(std::span<const Ray> rays, std::span<RayCounts> counts) const;

    [[nodiscard]] std::uint32_t depth() const noexcept;  ///< Edges on the longest path from the root to a leaf.

private:
    struct State;
    std::unique_ptr<const State> state_;
};

}  // namespace clbvh
