#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

namespace clbvh {

inline constexpr std::uint32_t kMaxLeafSize = 64;

/// The whole numbers that a field takes: those that pass every line.
struct WholeRule {
    std::uint32_t least = 0;
    std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t step = 1;               ///< Only its multiples.
    bool powers_of_two = false;           ///< Only powers of two.
    std::array<std::uint32_t, 3> only{};  ///< Only these, where the first is not 0; a 0 ends the list.
    bool or_chosen = false;               ///< And 0 beside all of them: then the value is chosen.
};

/// The real numbers that a field takes: finite, and least .. most.
struct RealRule {
    float least = 0.0f;
    float most = std::numeric_limits<float>::max();
    bool above_least = false;  ///< `least` itself is not among them.
};

inline constexpr RealRule kPositive{.above_least = true};

[[nodiscard]] bool allows(const WholeRule& rule, std::uint32_t value) noexcept;
[[nodiscard]] bool allows(const RealRule& rule, float value) noexcept;

/// The values that such a rule allows, for people: "1 to 32", "8 or 16", "finite and above 0".
[[nodiscard]] std::string text_of(const WholeRule& rule);
[[nodiscard]] std::string text_of(const RealRule& rule);

/// "A", "A or B", "A, B or C".
[[nodiscard]] std::string one_of(std::span<const std::string> names);

/// Throws Error(invalid_input): "FIELD is VALUE; it must be RANGE".
[[noreturn]] void reject_field(std::string_view field, const std::string& value, std::string_view range);

/// Throws as reject_field does where the rule does not allow `value`.
void check_field(std::string_view field, std::uint32_t value, const WholeRule& rule);
void check_field(std::string_view field, float value, const RealRule& rule);

/// Throws as reject_field does where `value` is not in least .. most; a NaN is in no range.
void check_range(std::string_view field, std::uint32_t value, std::uint32_t least, std::uint32_t most);
void check_range(std::string_view field, float value, float least, float most);

/// Throws as reject_field does where `value` is not finite and above 0.
void check_positive(std::string_view field, float value);

}  // namespace clbvh
