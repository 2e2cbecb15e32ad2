#include "io/read/ply_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "clbvh/core/error.hpp"
#include "io/read/words.hpp"

namespace clbvh::io {
namespace {

std::optional<PlyFormat> format_from(std::string_view name) {
    if (name == "ascii") return PlyFormat::ascii;
    if (name == "binary_little_endian") return PlyFormat::binary_little_endian;
    if (name == "binary_big_endian") return PlyFormat::binary_big_endian;
    return std::nullopt;
}

std::optional<PlyType> type_from(std::string_view name) {
    constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{
        {"char", PlyType::int8},
        {"int8", PlyType::int8},
        {"uchar", PlyType::uint8},
        {"uint8", PlyType::uint8},
        {"short", PlyType::int16},
        {"int16", PlyType::int16},
        {"ushort", PlyType::uint16},
        {"uint16", PlyType::uint16},
        {"int", PlyType::int32},
        {"int32", PlyType::int32},
        {"uint", PlyType::uint32},
        {"uint32", PlyType::uint32},
        {"float", PlyType::float32},
        {"float32", PlyType::float32},
        {"double", PlyType::float64},
        {"float64", PlyType::float64},
    }};
    const auto* const found = std::ranges::find(kTypes, name, &std::pair<std::string_view, PlyType>::first);
    if (found == kTypes.end()) return std::nullopt;
    return found->second;
}

std::vector<std::string_view> split_words(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line))
        words.push_back(word);
    return words;
}

class HeaderParser {
public:
    HeaderParser(std::string_view file, const std::string& name) : file_(file), name_(name) {
        position_ = file.size() - without_byte_order_mark(file).size();
    }

    PlyHeader parse() {
        const std::string_view first = file_.substr(position_, file_.find('\n', position_) - position_);
        if (!first.starts_with("ply")) fail_at(1, "not a PLY file: the first line is not \"ply\"");
        if (!is_word(split_words(take_line()), "ply")) fail("not a PLY file: the first line is not \"ply\"");
        parse_format(take_words());
        for (auto words = take_words(); !is_word(words, "end_header"); words = take_words())
            parse_declaration(words);
        for (const PlyElement& element : header_.elements) {
            if (element.properties.empty() && element.count > 0)
                fail("element \"" + element.name + "\" has no property");
        }
        header_.body = position_;
        return std::move(header_);
    }

private:
    static bool is_word(const std::vector<std::string_view>& words, std::string_view word) {
        return words.size() == 1 && words[0] == word;
    }
    /// Those of the next line that is neither empty nor a comment.
    std::vector<std::string_view> take_words() {
        while (true) {
            std::vector<std::string_view> words = split_words(take_line());
            if (!words.empty() && words[0] != "comment" && words[0] != "obj_info") return words;
        }
    }

    /// A file whose first line ends with CR alone has such lines throughout.
    std::string_view take_line() {
        if (line_number_++ == 0) {
            const std::size_t end = std::min(file_.find_first_of("\r\n", position_), file_.size());
            if (end < file_.size() && !file_.substr(end).starts_with("\r\n")) line_end_ = file_[end];
        }
        const std::size_t end = file_.find(line_end_, position_);
        if (end == std::string_view::npos) fail("the header has no end");
        std::string_view line = file_.substr(position_, end - position_);
        position_ = end + 1;
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }

    void parse_format(const std::vector<std::string_view>& words) {
        if (words.size() != 3 || words[0] != "format") fail("expected \"format NAME 1.0\"");
        const std::optional<PlyFormat> format = format_from(words[1]);
        if (!format || words[2] != "1.0") fail("unknown format " + quote(words[1]) + " " + quote(words[2]));
        header_.format = *format;
    }

    void parse_declaration(const std::vector<std::string_view>& words) {
        const std::string_view keyword = words[0];
        if (keyword == "element") return parse_element(words);
        if (keyword == "property") return parse_property(words);
        fail("unknown keyword " + quote(keyword));
    }

    void parse_element(const std::vector<std::string_view>& words) {
        if (words.size() != 3) fail("expected \"element NAME COUNT\"");
        if (!names_.insert(words[1]).second) fail("a second element " + quote(words[1]));
        PlyElement& element = header_.elements.emplace_back();
        element.name = words[1];
        const std::string_view count = words[2];
        const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
        if (error != std::errc{} || end != count.data() + count.size()) fail(quote(count) + " is not a count");
    }

    void parse_property(const std::vector<std::string_view>& words) {
        if (header_.elements.empty()) fail("a property before the first element");
        PlyProperty property;
        property.is_list = words.size() > 1 && words[1] == "list";
        if (words.size() != (property.is_list ? 5U : 3U)) {
            fail(R"(expected "property TYPE NAME" or "property list COUNT_TYPE TYPE NAME")");
        }
        property.name = words.back();
        property.type = parse_type(words[words.size() - 2]);
        if (property.is_list) property.count_type = parse_type(words[2]);
        if (!is_integer(property.count_type)) fail("the count of a list must be an integer");
        header_.elements.back().properties.push_back(std::move(property));
    }

    [[nodiscard]] PlyType parse_type(std::string_view name) const {
        const std::optional<PlyType> type = type_from(name);
        if (!type) fail("unknown type " + quote(name));
        return *type;
    }

    [[noreturn]] void fail(const std::string& what) const { fail_at(line_number_, what); }
    [[noreturn]] void fail_at(std::uint64_t line, const std::string& what) const {
        throw Error(ErrorCode::io, name_ + ", line " + std::to_string(line) + ": " + what);
    }

    std::string_view file_;
    const std::string& name_;
    std::unordered_set<std::string_view> names_;
    std::size_t position_ = 0;
    std::uint64_t line_number_ = 0;
    char line_end_ = '\n';
    PlyHeader header_;
};

}  // namespace

PlyHeader parse_ply_header(std::string_view file, const std::string& name) {
    return HeaderParser(file, name).parse();
}

}  // namespace clbvh::io
