#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/wide.hpp"
#include "clbvh/trace/hit_filter.hpp"

namespace clbvh {

/// How a tracer traces.
struct TracerOptions {
    TriangleTest triangle_test = TriangleTest::watertight;
    std::uint32_t thread_count = 0;  ///< Threads of the calls for many rays, 1 to 1024; 0: all.
};

/// The hits of many rays: those of ray i are hits[begins[i] .. begins[i + 1]).
struct HitLists {
    std::vector<std::uint64_t> begins;  ///< One more than rays.
    std::vector<Hit> hits;
};

/// Traces rays on the host through a layout of eight children a node. Any number of threads may use it at a time.
///
/// The closest hit is the one with the smallest t, and among equal ones the smallest primitive. What rounding puts
/// before a triangle's own box counts from where the ray enters that box, and a ray that misses the box misses the
/// triangle: so the closest hit is the same bits with every tree, as long as its boxes contain whole triangles (with
/// split ones, hits whose t is rounded by more than 2^-18 may go another way). Triangles have no back: both sides are
/// hit. Where coordinates relative to the ray's origin exceed about 1e12, products overflow and triangles are missed.
class CLBVH_API Tracer {
public:
    /// Makes a layout of its own: tree and mesh may go.
    /// Throws Error(invalid_input) where the tree was not built over this mesh: nodes, ids or indices out of range, or
    /// loops.
    Tracer(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options = {});
    /// Takes the layout over.
    explicit Tracer(Wide8&& layout, const TracerOptions& options = {});
    /// Borrows the layout, which has to stay where it is as long as the tracer. What is made of it anew, or refitted,
    /// while no ray is traced, is what the next ray goes through.
    explicit Tracer(const Wide8& layout, const TracerOptions& options = {});
    Tracer(const Tracer&) = delete;
    Tracer(Tracer&&) noexcept;
    Tracer& operator=(const Tracer&) = delete;
    Tracer& operator=(Tracer&&) noexcept;
    ~Tracer();

    [[nodiscard]] Hit closest(const Ray& ray) const;  ///< The first hit along the ray.
    [[nodiscard]] bool any(const Ray& ray) const;     ///< Whether there is a hit at all; stops at the first one found.
    /// Of the hits that the filter lets count.
    [[nodiscard]] Hit closest(const Ray& ray, const HitFilter& filter) const;
    [[nodiscard]] bool any(const Ray& ray, const HitFilter& filter) const;
    /// Calls `visit` with every hit, ordered by t and then by primitive, until it returns false.
    void all(const Ray& ray, const std::function<bool(const Hit&)>& visit) const;

    /// Many rays at a time, in parallel; hits[i] is that of rays[i]. It is faster than ray by ray, and most so where
    /// neighbours in the span lie close together, as those of a camera do; the hits are the same. Throws
    /// Error(invalid_input) where the spans differ in length.
    void closest(std::span<const Ray> rays, std::span<Hit> hits) const;
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) const;  ///< 1 or 0 each.
    void closest(std::span<const Ray> rays, std::span<Hit> hits, const HitFilter& filter) const;
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, const HitFilter& filter) const;
    /// Every hit of each ray, ordered by t and then by primitive.
    [[nodiscard]] HitLists all(std::span<const Ray> rays) const;

    /// What is traced.
    [[nodiscard]] const Wide8& layout() const noexcept;

private:
    struct State;
    std::unique_ptr<const State> state_;
};

}  // namespace clbvh
