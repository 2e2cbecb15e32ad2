#pragma once

#include <span>
#include <string_view>

#include "clbvh/core/build_options.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Where a builder runs.
enum class BuilderKind : unsigned char { host, device };

/// One row of the table of builders.
struct BuilderInfo {
    std::string_view id;     ///< What users type, for example "plocpp".
    std::string_view title;  ///< One line for people.
    std::string_view paper;  ///< Authors and year.
    BuilderKind kind;
    bool uses_search_radius;                   ///< BuildOptions::search_radius matters; see reads_search_radius().
    bool uses_chunk_size = false;              ///< BuildOptions::chunk_size matters, in the lane shape.
    bool uses_single_group_threshold = false;  ///< BuildOptions::single_group_threshold matters.
    bool uses_hploc_options = false;           ///< Those of BuildOptions from hploc_quality on matter.
};

/// Whether BuildOptions::search_radius matters to a builder with these options: to hploc only with HplocSearch::window.
[[nodiscard]] constexpr bool reads_search_radius(const BuilderInfo& builder, const BuildOptions& options) noexcept {
    return builder.uses_search_radius && (!builder.uses_hploc_options || options.hploc_search == HplocSearch::window);
}

/// Every builder of the library, in the order in which tables list them.
[[nodiscard]] CLBVH_API std::span<const BuilderInfo> builders() noexcept;

/// The row of `id`, or of the builder that the preset `id` runs (see presets()). Throws Error(invalid_input) that lists
/// the known ids.
[[nodiscard]] CLBVH_API const BuilderInfo& find_builder(std::string_view id);

}  // namespace clbvh
