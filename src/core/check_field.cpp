#include "core/check_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>
#include <vector>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

std::string text_of(float value) {
    std::ostringstream text;
    text << value;
    return text.str();
}

/// Those of a rule that names each; empty where it names none.
std::span<const std::uint32_t> named_values(const WholeRule& rule) {
    const auto end = std::ranges::find(rule.only, 0u);
    return {rule.only.begin(), end};
}

std::string range_text(const WholeRule& rule) {
    if (const auto values = named_values(rule); !values.empty()) {
        std::vector<std::string> names;
        for (const std::uint32_t value : values)
            names.push_back(std::to_string(value));
        return one_of(names);
    }
    const std::string least = std::to_string(rule.least);
    if (rule.most == std::numeric_limits<std::uint32_t>::max()) return least + " or more";
    const std::string most = std::to_string(rule.most);
    if (rule.powers_of_two) return "a power of two from " + least + " to " + most;
    return least + " to " + most + (rule.step > 1 ? " in steps of " + std::to_string(rule.step) : "");
}

}  // namespace

bool allows(const WholeRule& rule, std::uint32_t value) noexcept {
    if (rule.or_chosen && value == 0) return true;
    if (const auto values = named_values(rule); !values.empty()) return std::ranges::count(values, value) > 0;
    return value >= rule.least && value <= rule.most && value % rule.step == 0 &&
           (!rule.powers_of_two || std::has_single_bit(value));
}

bool allows(const RealRule& rule, float value) noexcept {
    return value >= rule.least && value <= rule.most && !(rule.above_least && value == rule.least);
}

std::string text_of(const WholeRule& rule) {
    return range_text(rule) + (rule.or_chosen ? ", or 0 to have it chosen" : "");
}

std::string text_of(const RealRule& rule) {
    if (rule.above_least) return "finite and above " + text_of(rule.least);
    return text_of(rule.least) + " to " + text_of(rule.most);
}

std::string one_of(std::span<const std::string> names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
    return text;
}

void reject_field(std::string_view field, const std::string& value, std::string_view range) {
    throw Error(ErrorCode::invalid_input, std::string(field) + " is " + value + "; it must be " + std::string(range));
}

void check_field(std::string_view field, std::uint32_t value, const WholeRule& rule) {
    if (!allows(rule, value)) reject_field(field, std::to_string(value), text_of(rule));
}

void check_field(std::string_view field, float value, const RealRule& rule) {
    if (!allows(rule, value)) reject_field(field, text_of(value), text_of(rule));
}

void check_range(std::string_view field, std::uint32_t value, std::uint32_t least, std::uint32_t most) {
    check_field(field, value, {.least = least, .most = most});
}

void check_range(std::string_view field, float value, float least, float most) {
    check_field(field, value, RealRule{.least = least, .most = most});
}

void check_positive(std::string_view field, float value) {
    check_field(field, value, kPositive);
}

}  // namespace clbvh
