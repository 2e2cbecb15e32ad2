#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace clbvh::tool {

/// One of the nine ways to a tree that Aila, Karras and Laine 2013 compare in table 1.
struct NineBuilder {
    std::string_view id;          ///< What users type.
    std::string_view title;       ///< In the paper's table.
    std::string_view builder;     ///< An id of builders().
    std::string_view optimizers;  ///< As BuildOptions::optimizers.
    bool merges_leaves = true;    ///< All but LBVH, whose leaves stay as they are: one triangle each (section 3).
};

/// All of them, in the paper's order.
[[nodiscard]] std::span<const NineBuilder> nine_builders() noexcept;

/// Those of `list`, ids with commas between them or "all", each once, in the paper's order. Throws
/// Error(invalid_input) that lists the known ids.
[[nodiscard]] std::vector<NineBuilder> choose_nine(std::string_view list);

}  // namespace clbvh::tool
