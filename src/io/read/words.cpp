#include "io/read/words.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace clbvh::io {
namespace {

bool is_blank(char c) noexcept {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

/// Without a plus sign in front; a second sign makes it no number.
std::string_view without_plus(std::string_view word) noexcept {
    if (word.starts_with('+') && !word.starts_with("+-") && !word.starts_with("++")) word.remove_prefix(1);
    return word;
}

}  // namespace

std::string_view take_word(std::string_view& line) noexcept {
    const auto begin = std::ranges::find_if_not(line, is_blank);
    const auto end = std::find_if(begin, line.end(), is_blank);
    const std::string_view word(begin, end);
    line = std::string_view(end, line.end());
    return word;
}

std::optional<double> parse_number(std::string_view word) noexcept {
    word = without_plus(word);
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || error == std::errc::invalid_argument) return std::nullopt;
    if (error == std::errc{}) return value;
    // Too small and too large are the same error; a number of that kind is small where its exponent is negative, or,
    // without one, where it begins with zeros.
    const std::size_t exponent = word.find_first_of("eE");
    const bool is_small = exponent != std::string_view::npos ? word.substr(exponent + 1).starts_with('-')
                                                             : word.find_first_not_of("-0") == word.find('.');
    return is_small ? std::optional(0.0) : std::nullopt;
}

std::optional<std::int64_t> parse_whole(std::string_view word) noexcept {
    word = without_plus(word);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

std::string quote(std::string_view word) {
    return '"' + std::string(word.substr(0, 40)) + '"';
}

std::string number_text(double number) {
    const bool is_whole = number == std::floor(number) && std::abs(number) < 1e15;
    return is_whole ? std::to_string(static_cast<std::int64_t>(number)) : std::to_string(number);
}

std::string take_coordinates(std::string_view& line, std::span<double> coordinates, const char* missing) {
    for (double& coordinate : coordinates) {
        const std::string_view word = take_word(line);
        if (word.empty()) return missing;
        const std::optional<double> value = parse_number(word);
        if (!value) return quote(word) + " is not a coordinate";
        coordinate = *value;
    }
    return {};
}

std::string_view without_byte_order_mark(std::string_view text) noexcept {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    return text;
}

bool is_utf16(std::string_view text) noexcept {
    return text.starts_with("\xFE\xFF") || text.starts_with("\xFF\xFE");
}

std::string_view Lines::take() noexcept {
    std::size_t end = place_;
    while (end < text_.size() && text_[end] != '\n' && text_[end] != '\r')
        ++end;
    const std::string_view line = text_.substr(place_, end - place_);
    place_ = end;
    if (text_.substr(place_).starts_with("\r\n")) ++place_;
    if (place_ < text_.size()) ++place_;
    ++number_;
    return line;
}

}  // namespace clbvh::io
