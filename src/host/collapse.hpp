#pragma once

#include "clbvh/host/collapse.hpp"
#include "core/scratch.hpp"

namespace clbvh::host {

/// `config` is in range, `tree` is valid and another object than `result`. Takes about 24 bytes of scratch per inner
/// node.
void collapse(const Bvh& tree, const CollapseConfig& config, Scratch& scratch, Bvh& result);

}  // namespace clbvh::host
