#pragma once

#include "clbvh/host/sweep_sah.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range.
void build_sweep_sah(HostBuild& build, const SweepSahConfig& config);

/// As clbvh::build_sweep_sah(), into memory that an earlier build may have used. Errors of allocation come as they are.
void build_sweep_sah(std::span<const Aabb> bounds, const SweepSahConfig& config, Scratch& scratch, Bvh& result);

}  // namespace clbvh::host
