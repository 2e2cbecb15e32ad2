#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "core/scratch.hpp"
#include "host/build/host_stages.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// One build on the host: what goes in, where it may work, what comes out.
struct HostBuild {
    std::span<Reference> references;  ///< The active primitives, at least one; the builder may move and overwrite them.
    const Bounds& bounds;             ///< Of all references.
    const Mesh* mesh;                 ///< The triangles; null where only their boxes are known.
    Scratch& scratch;                 ///< Every array of the size of the input comes from here.
    HostStages& stages;               ///< The builder begins its own stages, from fraction 0.05 to 1.
    Bvh& result;                      ///< Nodes and ids are to be filled; its vectors may hold an older tree.
};

/// A host builder with its options bound.
using BoundAlgorithm = std::function<void(HostBuild&)>;

/// What a build takes its primitives from.
struct HostInput {
    const Mesh& boxes;           ///< Passed by check_mesh; the boxes of its triangles are built over.
    const Mesh& triangles;       ///< What HostBuild::mesh refers to: the same, or what the boxes are parts of.
    std::uint64_t active_count;  ///< Active triangles of `boxes`.
};

/// Builds into `result`. Scratch and result may be those of an earlier build: their memory is used again.
BuildStats run_host_build(const HostInput& input, const BoundAlgorithm& algorithm, const ProgressCallback& progress,
                          Scratch& scratch, Bvh& result);

/// One call from a mesh to a tree; throws what check_mesh throws.
[[nodiscard]] Bvh build_over_mesh(const Mesh& mesh, const BoundAlgorithm& algorithm);

/// One call from boxes to a tree, where primitive i is bounds[i]. Throws Error(invalid_input) naming the first box that
/// has a NaN, is inverted or lies beyond kMaxCoordinate, Error(unsupported) where there are more than kMaxPrimitives.
[[nodiscard]] Bvh build_over_boxes(std::span<const Aabb> bounds, const BoundAlgorithm& algorithm);

/// The same into memory that an earlier build may have used. Errors of allocation come as they are.
void build_over_boxes(std::span<const Aabb> bounds, const BoundAlgorithm& algorithm, Scratch& scratch, Bvh& result);

}  // namespace clbvh::host
