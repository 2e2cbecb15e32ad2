#pragma once

#include "clbvh/host/aac.hpp"
#include "host/agglomerative/aac_clustering.hpp"
#include "host/build/host_build.hpp"

namespace clbvh::host {

/// `config` is in range.
void build_aac(HostBuild& build, const AacConfig& config);

namespace aac {

/// Choices that the paper fixes and tests vary.
struct Variant {
    Reduction reduction;
    simd::InstructionSet instruction_set = simd::instruction_set();
};

/// As build_aac, with all choices open.
void build(HostBuild& build, const AacConfig& config, const Variant& variant);

}  // namespace aac
}  // namespace clbvh::host
