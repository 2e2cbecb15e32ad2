#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"
#include "clbvh/trace/tracer.hpp"

namespace clbvh {

/// Traces rays through the binary tree as it is, node by node, and counts what each ray costs: for measuring trees. It
/// finds the bits that Tracer finds, at half its speed or less. Copies what it needs: tree and mesh may go. Any number
/// of threads may use it at a time.
class CLBVH_API BinaryTracer {
public:
    /// Throws Error(invalid_input) where the tree was not built over this mesh: nodes, ids or indices out of range, or
    /// loops.
    BinaryTracer(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options = {});
    BinaryTracer(const BinaryTracer&) = delete;
    BinaryTracer(BinaryTracer&&) noexcept;
    BinaryTracer& operator=(const BinaryTracer&) = delete;
    BinaryTracer& operator=(BinaryTracer&&) noexcept;
    ~BinaryTracer();

    /// As Tracer's, and what it cost: added to `counts`.
    [[nodiscard]] Hit closest(const Ray& ray, RayCounts& counts) const;
    [[nodiscard]] bool any(const Ray& ray, RayCounts& counts) const;

    /// The nodes and triangles that the ray would visit if no hit ended it: every inner node and leaf whose box it
    /// meets up to t_max, and their triangles. Over random lines through the root's box these add up to the SAH cost.
    [[nodiscard]] RayCounts visits(const Ray& ray) const;

    /// Many rays at a time, in parallel; counts[i] is set, not added to. Throws Error(invalid_input) where the spans
    /// differ in length.
    void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) const;
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) const;
    void visits(std::span<const Ray> rays, std::span<RayCounts> counts) const;

    [[nodiscard]] std::uint32_t depth() const noexcept;  ///< Edges on the longest path from the root to a leaf.

private:
    struct State;
    std::unique_ptr<const State> state_;
};

}  // namespace clbvh
