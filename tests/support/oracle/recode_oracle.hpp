#pragma once

#include "support/oracle/morton_oracle.hpp"

namespace clbvh::test {

/// What a device builder documentedly does to packed keys in Morton order where more than 32 share a code: each such
/// run gets codes within its own bounds, and is sorted by them; where it is long, bits of the codes that decide nothing
/// are left out before; in two rounds.
void recode(MortonOrder& order);

}  // namespace clbvh::test
