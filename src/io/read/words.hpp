#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

// Words and numbers of text files.
namespace clbvh::io {

/// Takes the next word off the front of `line`; empty where there is none. Words are parted by blanks and tabs.
std::string_view take_word(std::string_view& line) noexcept;

/// A number as people write it: with a plus sign or not, too small for a double (0), NaN or infinite by name. Nothing
/// where it is none, or too large for a double.
[[nodiscard]] std::optional<double> parse_number(std::string_view word) noexcept;

/// A whole number of 64 bits, with a sign or not. Nothing where it is none.
[[nodiscard]] std::optional<std::int64_t> parse_whole(std::string_view word) noexcept;

/// The beginning of a word in quotes, for errors.
[[nodiscard]] std::string quote(std::string_view word);
/// A number for errors: without a fraction where it has none.
[[nodiscard]] std::string number_text(double number);

/// Takes the next numbers off the front of `line`. Returns what is wrong where one is missing (`missing`) or is none;
/// empty where all is well.
[[nodiscard]] std::string take_coordinates(std::string_view& line, std::span<double> coordinates,
                                           const char* missing = "a vertex needs three coordinates");

/// The letter in lower case, where it is one of ASCII.
[[nodiscard]] constexpr char lower_case(char c) noexcept {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// The text behind a byte order mark of UTF-8, if there is one.
[[nodiscard]] std::string_view without_byte_order_mark(std::string_view text) noexcept;
/// Whether the text begins with the byte order mark of UTF-16.
[[nodiscard]] bool is_utf16(std::string_view text) noexcept;

/// The lines of a text one after the other. They end with LF, CR LF or CR.
class Lines {
public:
    explicit Lines(std::string_view text) noexcept : text_(text) {}

    /// Whether there is no other line.
    [[nodiscard]] bool at_end() const noexcept { return place_ == text_.size(); }
    [[nodiscard]] std::string_view take() noexcept;
    /// Of the line that was taken last, from 1.
    [[nodiscard]] std::uint64_t number() const noexcept { return number_; }
    /// Where the next line begins, in bytes.
    [[nodiscard]] std::size_t place() const noexcept { return place_; }

private:
    std::string_view text_;
    std::size_t place_ = 0;
    std::uint64_t number_ = 0;
};

}  // namespace clbvh::io
