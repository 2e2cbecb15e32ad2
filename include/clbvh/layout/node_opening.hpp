#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh {

/// Which nodes of the binary tree become the children of a node of many children.
enum class NodeOpening : std::uint8_t {
    largest_first,  ///< The one with the largest box is opened until there is no room for more.
    least_cost      ///< Those of the tree with the least SAH cost of all: slower to find, see docs/layouts.md.
};

/// "largest-first", "least-cost"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(NodeOpening opening) noexcept {
    switch (opening) {
        case NodeOpening::largest_first: return "largest-first";
        case NodeOpening::least_cost: return "least-cost";
    }
    return {};
}

}  // namespace clbvh
