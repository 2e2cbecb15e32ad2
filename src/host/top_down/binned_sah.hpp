#pragma once

#include "clbvh/host/binned_sah.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range.
void build_binned_sah(HostBuild& build, const BinnedSahConfig& config);

}  // namespace clbvh::host
