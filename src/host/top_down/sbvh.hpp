#pragma once

#include "clbvh/host/sbvh.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range; `build` has a mesh.
void build_sbvh(HostBuild& build, const SbvhConfig& config);

}  // namespace clbvh::host
