#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/options.hpp>
#include <memory>
#include <vector>

#include "measure/contestant.hpp"

namespace clbvh::tool {

/// Throws Error(unsupported) where this program was built without Embree 3, saying what to install, or where Embree
/// cannot do what `options` ask for.
void check_embree_peers(const BuildOptions& options);

/// Embree's builders of binary trees (rtcBuildBVH) over a mesh that check_mesh passes and that outlives them:
/// embree-morton, embree-binned and embree-sbvh are its low, medium and high quality. Throws as check_embree_peers
/// does.
///
/// They obey max_leaf_size (8 where not given; embree-morton knows no SAH and fills its leaves where it is given, else
/// makes leaves of one), the two costs, sbvh.reference_budget (the capacity of embree-sbvh's array, as a multiple of
/// the primitives) and thread_count. Timed is what a builder of clbvh does too: from the mesh over the primitives'
/// boxes to a finished tree, in memory that is kept between runs. Reading the tree back is not. Behind them stands what
/// make_embree_commit makes.
[[nodiscard]] std::vector<std::unique_ptr<TreeContestant>> make_embree_peers(const BuildOptions& options,
                                                                             const Mesh& mesh);

}  // namespace clbvh::tool
