// Stands in for embree_peer.cpp where Embree 3 was not found.
#include <clbvh/core/error.hpp>

#include "embree/embree_peer.hpp"
#include "embree/embree_scene.hpp"

namespace clbvh::tool {

void check_embree_peers(const BuildOptions&) {
    throw Error(ErrorCode::unsupported,
                "this clbvh was built without Embree 3, its peer in benchmarks; install libembree-dev, and configure "
                "and build again");
}

std::vector<std::unique_ptr<TreeContestant>> make_embree_peers(const BuildOptions& options, const Mesh&) {
    check_embree_peers(options);
    return {};
}

FirstRayEntrants make_embree_scenes(const BuildOptions& options, const Mesh&) {
    check_embree_peers(options);
    return {};
}

}  // namespace clbvh::tool
