#pragma once

#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// Throws Error(invalid_input) for a negative or non-finite cost.
void check_costs(const SahCosts& costs);

}  // namespace clbvh
