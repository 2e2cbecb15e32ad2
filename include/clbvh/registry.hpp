#pragma once

#include <span>
#include <string_view>

namespace clbvh {

/// Where a builder runs.
enum class BuilderKind : unsigned char { host, device };

/// One row of the table of builders.
struct BuilderInfo {
    std::string_view id;     ///< What users type, for example "plocpp".
    std::string_view title;  ///< One line for people.
    std::string_view paper;  ///< Authors and year.
    BuilderKind kind;
    bool uses_search_radius;                   ///< BuildOptions::search_radius matters.
    bool uses_chunk_size = false;              ///< BuildOptions::chunk_size matters, in the lane shape.
    bool uses_single_group_threshold = false;  ///< BuildOptions::single_group_threshold matters.
};

/// Every builder of the library, in the order in which tables list them.
[[nodiscard]] std::span<const BuilderInfo> builders() noexcept;

/// The row of `id`. Throws Error(invalid_input) that lists the known ids.
[[nodiscard]] const BuilderInfo& find_builder(std::string_view id);

}  // namespace clbvh
