#include "metrics/check_costs.hpp"

#include <cmath>
#include <sstream>
#include <string_view>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

void check_cost(std::string_view name, double cost) {
    if (std::isfinite(cost) && cost >= 0.0) return;
    std::ostringstream message;
    message << "the SAH cost of " << name << " is " << cost << "; it must be finite and not negative";
    throw Error(ErrorCode::invalid_input, message.str());
}

}  // namespace

void check_costs(const SahCosts& costs) {
    check_cost("an inner node", costs.inner);
    check_cost("a primitive", costs.primitive);
}

}  // namespace clbvh
