#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/options.hpp>
#include <memory>

#include "measure/contestant.hpp"

namespace clbvh::tool {

/// The build that an application of Embree waits for: rtcCommitScene over one mesh of triangles, scene and geometry at
/// low build quality (a Morton builder), under the id embree-commit-low. The mesh passes check_mesh and outlives the
/// contestant.
///
/// Timed is the commit of the scene alone. The scene is a dynamic one and stays from run to run, as other contestants
/// keep their memory; before each run its geometry is marked as changed, so that all of it is built anew. That marking,
/// and the geometry's own commit, which copies nothing, stand before the timed part. The tree, with wide nodes and
/// leaves that hold vertices, cannot be read.
[[nodiscard]] std::unique_ptr<TreeContestant> make_embree_commit(const BuildOptions& options, const Mesh& mesh);

}  // namespace clbvh::tool
