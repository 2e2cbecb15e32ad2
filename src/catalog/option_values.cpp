#include "catalog/option_values.hpp"

#include <array>
#include <charconv>
#include <optional>
#include <system_error>

namespace clbvh {
namespace {

constexpr std::array kTypes{OptionType::whole, OptionType::real, OptionType::boolean, OptionType::choice,
                            OptionType::text};
static_assert(kTypes.size() == std::variant_size_v<OptionValue>);

constexpr std::string_view kOn = "on";
constexpr std::string_view kOff = "off";

/// The number that is all of `text`.
template <typename Number>
std::optional<Number> parse(std::string_view text) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc{} || rest != end) return std::nullopt;
    return number;
}

std::string shortest(float number) {
    std::array<char, 32> text;
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

std::vector<std::string_view> names_of(const ChoiceValue& choice) {
    std::vector<std::string_view> names;
    for (unsigned value = 0; !choice.name(value).empty(); ++value)
        names.push_back(choice.name(value));
    return names;
}

std::string allowed(const WholeValue& value) {
    return text_of(value.rule);
}
std::string allowed(const RealValue& value) {
    return text_of(value.rule);
}
std::string allowed(const SwitchValue&) {
    return std::string(kOn) + " or " + std::string(kOff);
}
std::string allowed(const ChoiceValue& value) {
    const std::vector<std::string_view> names = names_of(value);
    return one_of(std::vector<std::string>(names.begin(), names.end()));
}
std::string allowed(const TextValue& value) {
    return std::string(value.values);
}

std::string get(const WholeValue& value, const BuildOptions& options) {
    return std::to_string(value.member.of(options));
}
std::string get(const RealValue& value, const BuildOptions& options) {
    return shortest(value.member.of(options));
}
std::string get(const SwitchValue& value, const BuildOptions& options) {
    return std::string(value.member.of(options) ? kOn : kOff);
}
std::string get(const ChoiceValue& value, const BuildOptions& options) {
    const unsigned number = value.get(options);
    const std::string_view name = value.name(number);
    return name.empty() ? std::to_string(number) : std::string(name);
}
std::string get(const TextValue& value, const BuildOptions& options) {
    return value.member.of(options);
}

void check(const WholeValue& value, std::string_view name, const BuildOptions& options) {
    check_field(name, value.member.of(options), value.rule);
}
void check(const RealValue& value, std::string_view name, const BuildOptions& options) {
    check_field(name, value.member.of(options), value.rule);
}
void check(const SwitchValue&, std::string_view, const BuildOptions&) {}
void check(const ChoiceValue& value, std::string_view name, const BuildOptions& options) {
    if (value.name(value.get(options)).empty()) reject_field(name, get(value, options), allowed(value));
}
void check(const TextValue& value, std::string_view, const BuildOptions& options) {
    value.check(value.member.of(options));
}

// These say whether `text` is a value at all.
bool read(const WholeValue& value, std::string_view text, BuildOptions& options) {
    const std::optional<std::uint32_t> number = parse<std::uint32_t>(text);
    if (number) value.member.in(options) = *number;
    return number.has_value();
}
bool read(const RealValue& value, std::string_view text, BuildOptions& options) {
    const std::optional<float> number = parse<float>(text);
    if (number) value.member.in(options) = *number;
    return number.has_value();
}
bool read(const SwitchValue& value, std::string_view text, BuildOptions& options) {
    value.member.in(options) = text == kOn;
    return text == kOn || text == kOff;
}
bool read(const ChoiceValue& value, std::string_view text, BuildOptions& options) {
    const std::vector<std::string_view> names = names_of(value);
    for (unsigned i = 0; i < names.size(); ++i) {
        if (names[i] != text) continue;
        value.set(options, i);
        return true;
    }
    return false;
}
bool read(const TextValue& value, std::string_view text, BuildOptions& options) {
    value.member.in(options) = text;
    return true;
}

}  // namespace

OptionType type_of(const OptionValue& value) noexcept {
    return kTypes[value.index()];
}

std::string values_text(const OptionValue& value) {
    return std::visit([](const auto& v) { return allowed(v); }, value);
}

std::vector<std::string_view> choices_of(const OptionValue& value) {
    const auto* const choice = std::get_if<ChoiceValue>(&value);
    return choice == nullptr ? std::vector<std::string_view>{} : names_of(*choice);
}

std::string get_value(const OptionValue& value, const BuildOptions& options) {
    return std::visit([&](const auto& v) { return get(v, options); }, value);
}

void set_value(const OptionValue& value, std::string_view name, std::string_view text, BuildOptions& options) {
    BuildOptions changed = options;
    if (!std::visit([&](const auto& v) { return read(v, text, changed); }, value)) {
        reject_field(name, "'" + std::string(text) + "'", values_text(value));
    }
    check_value(value, name, changed);
    options = std::move(changed);
}

void check_value(const OptionValue& value, std::string_view name, const BuildOptions& options) {
    std::visit([&](const auto& v) { check(v, name, options); }, value);
}

}  // namespace clbvh
