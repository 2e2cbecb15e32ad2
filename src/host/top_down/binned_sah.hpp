#pragma once

#include <span>

#include "clbvh/host/binned_sah.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range.
void build_binned_sah(HostBuild& build, const BinnedSahConfig& config);

/// As clbvh::build_binned_sah(), into memory that an earlier build may have used. Errors of allocation come as they
/// are.
void build_binned_sah(std::span<const Aabb> bounds, const BinnedSahConfig& config, Scratch& scratch, Bvh& result);

}  // namespace clbvh::host
