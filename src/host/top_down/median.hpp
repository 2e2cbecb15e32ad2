#pragma once

#include "clbvh/host/median.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range.
void build_median(HostBuild& build, const MedianConfig& config);

}  // namespace clbvh::host
