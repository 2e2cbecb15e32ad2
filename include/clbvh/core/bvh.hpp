#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clbvh/core/aabb.hpp"

namespace clbvh {

/// One node of a binary BVH; 32 bytes, little-endian, the same on host and device.
///
/// count == 0: an inner node; its children are nodes `first` and `first + 1`, and `first` is even.
/// count > 0: a leaf over primitive_ids[first .. first + count).
struct Node {
    float lower[3];
    std::uint32_t first;
    float upper[3];
    std::uint32_t count;

    [[nodiscard]] constexpr bool is_leaf() const noexcept { return count > 0; }
    [[nodiscard]] constexpr Aabb bounds() const noexcept {
        return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
    }
    friend constexpr bool operator==(const Node&, const Node&) = default;
};
static_assert(sizeof(Node) == 32 && offsetof(Node, upper) == 16);

/// A bounding volume hierarchy. The root is node 0 and node 1 is an unused zero, so that every sibling pair starts at
/// an even index and fills one 64-byte line. Empty where no primitive is active. No order between a parent's and a
/// child's index is promised, and slots that no node uses may lie between used ones.
struct Bvh {
    std::vector<Node> nodes;
    std::vector<std::uint32_t> primitive_ids;  ///< Leaves refer to ranges of this array; its values are primitives.
    std::uint64_t primitive_count = 0;         ///< Primitives of the input, the inactive ones included.
    /// True where a builder was free to cut primitives in parts: one primitive may then be in several leaves, each of
    /// whose boxes covers only a part of it, and primitive_ids may hold more ids than there are primitives.
    bool split_references = false;

    [[nodiscard]] bool empty() const noexcept { return nodes.empty(); }
};

}  // namespace clbvh
