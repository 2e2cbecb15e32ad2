#pragma once

#include <cstdint>

#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"
#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// The end-point overlap (EPO) of a tree: the expected cost of the nodes in which a point of the scene's surface lies
/// though its triangle is in none of their leaves. Rays begin and end on surfaces, and have to visit such nodes in
/// vain.
///
/// Aila, Karras, Laine 2013, equation 3: the sum over all nodes n of C_n A((S without Q(n)) within n) / A(S), where S
/// are all triangles, Q(n) those that a leaf below n names, and A(...) the area of the others' parts in n's box, faces
/// included. C_n is C_inner, or C_primitive |leaf|. 0 where no node's box holds another's triangles, and lower is
/// better. A triangle that was split belongs, whole, to every node above each leaf that names it.
///
/// Exact but for rounding in double precision: each triangle goes down the tree and is clipped against the boxes that
/// it meets. In parallel, with the same result on any number of threads; time grows with the number of boxes that
/// triangles meet: about n log n over most scenes, up to n^2 where each meets a share of all (long thin triangles
/// across the axes). An empty tree, or a scene without area, has none. Throws Error(invalid_input) for a negative or
/// non-finite cost, for a mesh that check_mesh refuses and for a tree that was not built over this mesh,
/// Error(cancelled) where `progress` says so; it is called on the calling thread, with the stage "epo".
[[nodiscard]] CLBVH_API double end_point_overlap(const Bvh& bvh, const MeshView& mesh, const SahCosts& costs = {},
                                                 const ProgressCallback& progress = {});

/// A mean of samples, and how far from the truth it is to be expected.
struct Estimate {
    double value = 0.0;
    double standard_error = 0.0;  ///< Two thirds of all estimates are closer than this.
};

/// Samples of an estimate: at least 2, without which there is no standard error; at most 2^32, which take days.
inline constexpr std::uint64_t kFewestEpoSamples = 2;
inline constexpr std::uint64_t kMostEpoSamples = std::uint64_t{1} << 32;

/// The same from `samples` points, spread uniformly over the surfaces: faster for large scenes, most of all where large
/// triangles meet many boxes. Depends on `seed`, not on the number of threads.
/// Throws as end_point_overlap does, and Error(invalid_input) for a number of samples that is out of range.
[[nodiscard]] CLBVH_API Estimate end_point_overlap_sampled(const Bvh& bvh, const MeshView& mesh, std::uint64_t samples,
                                                           std::uint64_t seed = 1, const SahCosts& costs = {});

}  // namespace clbvh
