#pragma once

#include "clbvh/host/locally_ordered.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

void build_locally_ordered(HostBuild& build);

}  // namespace clbvh::host
