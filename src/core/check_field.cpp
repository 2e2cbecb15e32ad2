#include "core/check_field.hpp"

#include <cmath>
#include <sstream>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

std::string text_of(float value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

}  // namespace

void reject_field(std::string_view field, const std::string& value, std::string_view range) {
    throw Error(ErrorCode::invalid_input, std::string(field) + " is " + value + "; it must be " + std::string(range));
}

void check_range(std::string_view field, std::uint32_t value, std::uint32_t least, std::uint32_t most) {
    if (value >= least && value <= most) return;
    reject_field(field, std::to_string(value), std::to_string(least) + " to " + std::to_string(most));
}

void check_range(std::string_view field, float value, float least, float most) {
    if (value >= least && value <= most) return;
    reject_field(field, text_of(value), text_of(least) + " to " + text_of(most));
}

void check_positive(std::string_view field, float value) {
    if (std::isfinite(value) && value > 0.0f) return;
    reject_field(field, text_of(value), "finite and above 0");
}

}  // namespace clbvh
