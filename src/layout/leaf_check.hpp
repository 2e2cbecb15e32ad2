#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"

// What validators of layouts share.
namespace clbvh::layout {

/// Throws Error(invalid_input): "the layout is not valid: " and `fault`.
[[noreturn]] void reject_layout(const std::string& fault);

/// Throws where something of `used` is false: "`what` 7 is not part of the tree".
void reject_unused(const std::vector<bool>& used, const char* what);

/// Throws where a layout says another depth than it has.
void check_depth(std::size_t stated, std::size_t found);

/// Every comparison is false for a NaN.
[[nodiscard]] bool contains(const Aabb& outer, const Aabb& inner) noexcept;

/// Proves of the leaves of a layout, one after the other, that together they hold every active primitive, once, within
/// their boxes; with split references at least once, and so that no part is in none of the boxes. Holds no inactive
/// ones. All throw Error(invalid_input) naming the first offender.
class LeafCheck {
public:
    /// Throws what check_primitives does, and where their number is not `primitive_count`. Where `joins_leaves`, leaves
    /// may be several of the binary tree's, and so name a split primitive more than once.
    LeafCheck(const Primitives& primitives, std::uint64_t primitive_count, bool split_references, bool joins_leaves);

    /// The leaf that is node `node`, or in slot `slot`, below 8, of it.
    void add(std::size_t node, const Aabb& box, std::span<const std::uint32_t> ids, std::size_t slot = 0);

    /// There are no more leaves.
    void finish();

private:
    /// What is wrong with a reference; nullptr where nothing is.
    [[nodiscard]] const char* find_fault(std::size_t leaf, const Aabb& box, std::uint32_t id) const;

    Primitives primitives_;
    std::uint64_t count_;
    std::uint64_t inactive_;
    bool split_references_;
    bool may_repeat_;  ///< A primitive in one leaf.
    std::uint64_t reached_ = 0;
    std::vector<std::size_t> last_leaf_;  ///< One per primitive: 1 + the last leaf that named it, or 0.
    Bvh leaves_;                          ///< With split references: nothing but leaves.
};

}  // namespace clbvh::layout
