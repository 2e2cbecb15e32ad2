#pragma once

#include "clbvh/host/sweep_sah.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range.
void build_sweep_sah(HostBuild& build, const SweepSahConfig& config);

}  // namespace clbvh::host
