#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh {

/// The references of a tree's leaves, numbered as a walk over the tree meets them, first child first. Whatever a
/// subtree names is then one range of numbers, and whether a triangle is in it is a matter of comparing numbers.
class LeafOrder {
public:
    /// Numbers of references, from `begin` up to `end`.
    struct Range {
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
    };

    /// Throws Error(invalid_input) where the tree was not built over a mesh of so many triangles: children, ids or
    /// ranges out of range, or a node with two parents.
    LeafOrder(const Bvh& bvh, std::uint64_t triangle_count);

    /// The nodes as the walk meets them: parents before their children.
    [[nodiscard]] std::span<const std::uint32_t> nodes() const noexcept { return nodes_; }
    [[nodiscard]] std::size_t reference_count() const noexcept { return triangles_.size(); }
    /// The triangle of a reference.
    [[nodiscard]] std::uint32_t triangle(std::size_t reference) const noexcept { return triangles_[reference]; }
    /// All references to a triangle, ascending.
    [[nodiscard]] std::span<const std::uint32_t> references(std::uint32_t triangle) const noexcept {
        return {references_.data() + begins_[triangle], references_.data() + begins_[triangle + 1]};
    }
    /// The references in the leaves of node `node`'s subtree. Means nothing for a slot that no node uses.
    [[nodiscard]] const Range& below(std::uint32_t node) const noexcept { return ranges_[node]; }

private:
    void number_references(const Bvh& bvh, std::uint64_t triangle_count);
    void list_references(std::uint64_t triangle_count);

    std::vector<std::uint32_t> nodes_;
    std::vector<Range> ranges_;
    std::vector<std::uint32_t> triangles_;
    std::vector<std::uint64_t> begins_;
    std::vector<std::uint32_t> references_;
};

/// True where one of a triangle's references, ascending, is in the range.
[[nodiscard]] inline bool has_one_in(std::span<const std::uint32_t> references,
                                     const LeafOrder::Range& range) noexcept {
    for (const std::uint32_t reference : references) {
        if (reference >= range.begin) return reference < range.end;
    }
    return false;
}

}  // namespace clbvh
