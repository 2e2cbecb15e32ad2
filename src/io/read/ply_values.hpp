#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io/read/ply_header.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {

/// Takes the binary values of a PLY file's body one after the other. Every type fits a double.
template <std::endian Order>
class BinaryPlyValues {
public:
    BinaryPlyValues(std::string_view file, std::size_t position) : file_(file), position_(position) {}

    /// The next value; nothing where the file ends.
    std::optional<double> take(PlyType type) {
        switch (type) {
            case PlyType::int8: return load<std::int8_t>();
            case PlyType::uint8: return load<std::uint8_t>();
            case PlyType::int16: return load<std::int16_t>();
            case PlyType::uint16: return load<std::uint16_t>();
            case PlyType::int32: return load<std::int32_t>();
            case PlyType::uint32: return load<std::uint32_t>();
            case PlyType::float32: return load<float>();
            case PlyType::float64: return load<double>();
        }
        return std::nullopt;
    }

    /// Why the last take() gave nothing.
    [[nodiscard]] std::string failure() const { return "the file ends here"; }

    /// Most items of so many values and bytes that can still come.
    [[nodiscard]] std::uint64_t room_for(std::size_t /*values*/, std::size_t bytes) const {
        return (file_.size() - position_) / std::max<std::size_t>(1, bytes);
    }

    [[nodiscard]] std::string where() const { return "byte " + std::to_string(position_); }
    [[nodiscard]] std::size_t position() const noexcept { return position_; }

    /// Nothing stands between items.
    void end_item() {}

private:
    template <typename T>
    std::optional<double> load() {
        if (file_.size() - position_ < sizeof(T)) return std::nullopt;
        std::array<char, sizeof(T)> bytes{};
        std::copy_n(file_.data() + position_, sizeof(T), bytes.begin());
        if constexpr (Order != std::endian::native) std::ranges::reverse(bytes);
        position_ += sizeof(T);
        return static_cast<double>(std::bit_cast<T>(bytes));
    }

    std::string_view file_;
    std::size_t position_;
};

/// Takes the numbers of an ASCII PLY file's body one after the other.
class TextPlyValues {
public:
    /// `is_by_lines`: each item begins a line, which may hold more than the item.
    TextPlyValues(std::string_view file, std::size_t position, bool is_by_lines)
        : file_(file), position_(position), is_by_lines_(is_by_lines) {}

    /// The next number; nothing where the file ends or something else stands there.
    std::optional<double> take(PlyType /*type*/) {
        position_ = std::min(file_.find_first_not_of(kSpace, position_), file_.size());
        const std::string_view digits = word();
        const std::optional<double> value = parse_number(digits);
        if (value) position_ += digits.size();
        return value;
    }

    /// Why the last take() gave nothing.
    [[nodiscard]] std::string failure() const {
        if (position_ == file_.size()) return "the file ends here";
        return quote(word()) + " is not a number";
    }

    /// Most items of so many numbers that can still come: a digit and a space a number.
    [[nodiscard]] std::uint64_t room_for(std::size_t values, std::size_t /*bytes*/) const {
        return (file_.size() - position_ + 1) / std::max<std::size_t>(1, 2 * values);
    }

    [[nodiscard]] std::string where() const {
        const std::string_view before = file_.substr(0, position_);
        return "line " + std::to_string(1 + std::ranges::count(before, '\n'));
    }

    [[nodiscard]] std::size_t position() const noexcept { return position_; }

    /// Skips what else stands in the line, where each item begins a line.
    void end_item() {
        if (is_by_lines_) position_ = std::min(file_.find_first_of("\r\n", position_), file_.size());
    }
    /// Whether nothing but space is left.
    [[nodiscard]] bool at_end() const { return file_.find_first_not_of(kSpace, position_) == std::string_view::npos; }

private:
    static constexpr std::string_view kSpace = " \t\r\n";

    /// The text from here to the next space.
    [[nodiscard]] std::string_view word() const {
        return file_.substr(position_, std::min(file_.find_first_of(kSpace, position_), file_.size()) - position_);
    }

    std::string_view file_;
    std::size_t position_;
    bool is_by_lines_;
};

}  // namespace clbvh::io
