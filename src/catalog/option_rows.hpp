#pragma once

#include <span>
#include <string_view>

#include "catalog/option_values.hpp"

namespace clbvh {

/// An option as the table states it; the fields are OptionInfo's.
struct OptionRow {
    std::string_view name;
    std::string_view flag;
    std::string_view group;
    OptionValue value;
    std::string_view readers;
    std::string_view help;
    std::string_view implied = {};
};

/// The table of options.
[[nodiscard]] std::span<const OptionRow> option_rows() noexcept;

}  // namespace clbvh
