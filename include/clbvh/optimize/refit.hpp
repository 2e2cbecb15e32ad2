#pragma once

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// What refit() did to a tree's cost. Where `after` has risen much over that of a fresh build, build anew.
struct RefitStats {
    double sah_before = 0.0;  ///< As sah_cost(), up to rounding: with the boxes that were there.
    double sah_after = 0.0;   ///< With the new ones.
};

/// Gives the tree the boxes that the mesh's vertices now ask for; its structure stays. O(n) time, in the calling task
/// arena of oneTBB, and cheap enough for every frame.
///
/// `mesh` has the triangles that the tree was built over, at new places. Where references were split, leaves get the
/// boxes of whole triangles. Throws Error(invalid_input), the tree being as it was, where the mesh has another number
/// of triangles, where check_mesh refuses it, where a cost is negative or not finite, or where another triangle than
/// before is inactive, naming it.
RefitStats refit(Bvh& tree, const Mesh& mesh, const SahCosts& costs = {});

}  // namespace clbvh
