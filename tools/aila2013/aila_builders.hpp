#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace clbvh::tool {

/// When leaves are merged as far as that lowers the SAH cost.
enum class LeafMerging : unsigned char {
    never,
    at_the_end,  ///< After the optimisers.
    twice,       ///< Before them too.
};

/// One of the nine ways to a tree that Aila, Karras and Laine 2013 compare in table 1.
struct AilaBuilder {
    std::string_view id;          ///< The name that users type.
    std::string_view title;       ///< In the paper's table.
    std::string_view builder;     ///< An id of builders().
    std::string_view optimizers;  ///< As BuildOptions::optimizers.
    LeafMerging leaves = LeafMerging::at_the_end;
};

/// All of them, in the paper's order. LBVH keeps its leaves of one triangle (section 3). Kensler's rotations work on
/// trees that have leaves of several (2008, section 5), so that LBVH's are merged for them first: annealing would
/// scatter what belongs into one leaf wherever that costs no area.
[[nodiscard]] std::span<const AilaBuilder> aila_builders() noexcept;

/// Those of `list`, ids with commas between them or "all", each once, in the paper's order. Throws
/// Error(invalid_input) that lists the known ids.
[[nodiscard]] std::vector<AilaBuilder> choose_aila_builders(std::string_view list);

}  // namespace clbvh::tool
