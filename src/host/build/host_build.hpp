#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "core/scratch.hpp"
#include "host/build/host_stages.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// One build on the host: what goes in, where it may work, what comes out.
struct HostBuild {
    std::span<Reference> references;  ///< The active primitives, at least one; the builder may move and overwrite them.
    const Bounds& bounds;             ///< Of all references.
    const MeshView* mesh;             ///< The triangles; null where only boxes are known.
    Scratch& scratch;                 ///< Every array of the size of the input comes from here.
    HostStages& stages;               ///< The builder begins its own stages, from fraction 0.05 to 1.
    Bvh& result;                      ///< Nodes and ids are to be filled; its vectors may hold an older tree.
};

/// A host builder with its options bound.
using BoundAlgorithm = std::function<void(HostBuild&)>;

/// The primitives of a build.
struct HostInput {
    Primitives primitives;           ///< Passed by check_primitives; their boxes are built over.
    std::uint64_t active_count = 0;  ///< Those of them that are active.
    std::optional<MeshView> cut;     ///< Boxes: the triangle that each one holds a part of, where that is known.
};

/// Builds into `result`. Scratch and result may be those of an earlier build: their memory is used again.
BuildStats run_host_build(const HostInput& input, const BoundAlgorithm& algorithm, const ProgressCallback& progress,
                          Scratch& scratch, Bvh& result);

/// One call from primitives to a tree; throws what check_primitives throws.
[[nodiscard]] Bvh build_over(const Primitives& primitives, const BoundAlgorithm& algorithm);

/// The same into memory that an earlier build may have used. Errors of allocation come as they are.
void build_over(const Primitives& primitives, const BoundAlgorithm& algorithm, Scratch& scratch, Bvh& result);

}  // namespace clbvh::host
