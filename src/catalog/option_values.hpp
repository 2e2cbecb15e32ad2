#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "clbvh/options.hpp"
#include "core/check_field.hpp"

namespace clbvh {

/// A member of BuildOptions, or of a Config in it.
template <typename T>
struct Member {
    T& (*in)(BuildOptions& options);
    const T& (*of)(const BuildOptions& options);
};

/// kMember<&BuildOptions::ploc, &PlocConfig::search_radius>: the path to such a member.
template <auto... Path>
inline constexpr auto kMember = [] {
    using T = std::remove_reference_t<decltype((std::declval<BuildOptions&>().*....*Path))>;
    return Member<T>{[](BuildOptions& options) -> T& { return (options.*....*Path); },
                     [](const BuildOptions& options) -> const T& { return (options.*....*Path); }};
}();

// The kinds of values that options have.

struct WholeValue {
    Member<std::uint32_t> member;
    WholeRule rule;
};

struct RealValue {
    Member<float> member;
    RealRule rule;
};

struct SwitchValue {
    Member<bool> member;
};

struct TextValue {
    Member<std::string> member;
    void (*check)(std::string_view text);  ///< Throws where it may not be so.
    std::string_view values;               ///< OptionInfo::values
};

/// An enumeration, whose values count from 0 and whose to_string is empty for what is none of them.
struct ChoiceValue {
    unsigned (*get)(const BuildOptions& options);
    void (*set)(BuildOptions& options, unsigned value);
    std::string_view (*name)(unsigned value);
};

/// The choice of kMember<Path...>.
template <auto... Path>
inline constexpr ChoiceValue kChoice = [] {
    using Enum = std::remove_reference_t<decltype(kMember<Path...>.in(std::declval<BuildOptions&>()))>;
    return ChoiceValue{
        [](const BuildOptions& options) { return static_cast<unsigned>(kMember<Path...>.of(options)); },
        [](BuildOptions& options, unsigned value) { kMember<Path...>.in(options) = static_cast<Enum>(value); },
        [](unsigned value) { return to_string(static_cast<Enum>(value)); }};
}();

using OptionValue = std::variant<WholeValue, RealValue, SwitchValue, ChoiceValue, TextValue>;

[[nodiscard]] OptionType type_of(const OptionValue& value) noexcept;

/// Which values are allowed, for people.
[[nodiscard]] std::string values_text(const OptionValue& value);

/// The names of a choice; none for other values.
[[nodiscard]] std::vector<std::string_view> choices_of(const OptionValue& value);

/// The member of `options` as a text.
[[nodiscard]] std::string get_value(const OptionValue& value, const BuildOptions& options);

/// Sets the member to what `text` says. Throws as check_value does, and then sets nothing.
void set_value(const OptionValue& value, std::string_view name, std::string_view text, BuildOptions& options);

/// Throws as reject_field does, for the field `name`, where the member is not allowed to be what it is.
void check_value(const OptionValue& value, std::string_view name, const BuildOptions& options);

}  // namespace clbvh
