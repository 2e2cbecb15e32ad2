#include "clbvh/core/validate.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/coverage.hpp"
#include "core/own_group.hpp"
#include "core/primitive_access.hpp"
#include "core/tree_walk.hpp"

namespace clbvh {
namespace {

std::string name_primitive(std::size_t primitive) {
    return "primitive " + std::to_string(primitive);
}

/// False also where `box` has a NaN or is inverted.
bool lies_within(const Aabb& box, const Aabb& outer) {
    const auto axis_within = [](float outer_lower, float lower, float upper, float outer_upper) {
        return outer_lower <= lower && lower <= upper && upper <= outer_upper;
    };
    return axis_within(outer.lower.x, box.lower.x, box.upper.x, outer.upper.x) &&
           axis_within(outer.lower.y, box.lower.y, box.upper.y, outer.upper.y) &&
           axis_within(outer.lower.z, box.lower.z, box.upper.z, outer.upper.z);
}

/// One validation. Every check returns what is wrong, or nothing.
class Validator {
public:
    Validator(const Bvh& bvh, const Primitives& primitives)
        : bvh_(bvh), primitives_(primitives), count_(count_of(primitives)) {}

    ValidationReport run() {
        report_.error = check();
        report_.valid = report_.error.empty();
        return report_;
    }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    /// Each step relies on what the steps before it have proven.
    std::string check() {
        if (std::string fault = check_input(); !fault.empty()) return fault;
        if (bvh_.empty()) return find_missing_primitive();
        if (std::string fault = check_node_array(); !fault.empty()) return fault;
        if (std::string fault = walk(); !fault.empty()) return fault;
        if (std::string fault = check_contents(); !fault.empty()) return fault;
        if (std::string fault = find_missing_primitive(); !fault.empty()) return fault;
        return bvh_.split_references ? check_coverage() : std::string{};
    }

    std::string check_input() {
        try {
            inactive_ = check_primitives(primitives_);
        } catch (const Error& error) {
            const bool is_mesh = std::holds_alternative<MeshView>(primitives_);
            return std::string(is_mesh ? "the mesh is" : "the boxes are") + " not valid: " + error.what();
        }
        if (bvh_.primitive_count == count_) return {};
        return "primitive_count is " + std::to_string(bvh_.primitive_count) + ", but " + count_in_words(primitives_);
    }

    std::string check_node_array() const {
        if (bvh_.nodes.size() < 2) return "node 1, the unused zero beside the root, is missing";
        if (bvh_.nodes[1] != Node{}) return "node 1 is not zero";
        return {};
    }

    /// Visits all nodes from the root, parents before children, left before right. Proves that they form a tree whose
    /// references are in range, that no primitive is referred to twice from one leaf, and, where references are not
    /// split, from two leaves neither.
    std::string walk() {
        order_.reserve(bvh_.nodes.size());
        leaf_of_primitive_.assign(count_, kNone);
        if (bvh_.split_references) id_reached_.assign(bvh_.primitive_ids.size(), false);
        TreeWalk walk(bvh_);
        while (walk.next()) {
            order_.push_back(walk.node());
            ++report_.nodes;
            report_.depth = std::max(report_.depth, walk.depth());
            if (!bvh_.nodes[walk.node()].is_leaf()) continue;
            if (std::string fault = enter_leaf(walk.node()); !fault.empty()) return fault;
        }
        return walk.fault();
    }

    std::string enter_leaf(std::size_t index) {
        const Node& node = bvh_.nodes[index];
        ++report_.leaves;
        for (std::size_t slot = node.first; slot < std::size_t{node.first} + node.count; ++slot) {
            if (std::string fault = enter_reference(index, slot); !fault.empty())
                return name_node(index) + ": " + fault;
        }
        return {};
    }

    std::string enter_reference(std::size_t leaf, std::size_t slot) {
        const std::uint32_t primitive = bvh_.primitive_ids[slot];
        if (primitive >= count_)
            return name_primitive(primitive) + " is out of range (" + count_in_words(primitives_) + ")";
        std::uint32_t& known_leaf = leaf_of_primitive_[primitive];
        if (known_leaf == leaf) return name_primitive(primitive) + " is in this leaf a second time";
        if (known_leaf != kNone && !bvh_.split_references) {
            return name_primitive(primitive) + " is in the tree a second time";
        }
        if (bvh_.split_references) {
            // Else a small array of ids could be walked once for each of many leaves.
            if (id_reached_[slot]) return "primitive id " + std::to_string(slot) + " belongs to another leaf";
            id_reached_[slot] = true;
        }
        if (known_leaf == kNone) ++primitives_reached_;
        known_leaf = static_cast<std::uint32_t>(leaf);
        return {};
    }

    /// Proves boxes and activity of all visited nodes, in parallel. An inner box is compared with the stored boxes of
    /// its children: once every node passes, each box is by induction the union of the primitives below it.
    std::string check_contents() const {
        constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
        const std::size_t first_fault = tbb::parallel_reduce(
            tbb::blocked_range<std::size_t>(0, order_.size(), 4096), none,
            [&](const auto& range, std::size_t best) {
                for (std::size_t i = range.begin(); i < range.end() && i < best; ++i) {
                    if (!check_content(order_[i]).empty()) best = i;
                }
                return best;
            },
            [](std::size_t a, std::size_t b) { return std::min(a, b); });
        return first_fault == none ? std::string{} : check_content(order_[first_fault]);
    }

    std::string check_content(std::size_t index) const {
        const Node& node = bvh_.nodes[index];
        Aabb expected;
        if (node.is_leaf()) {
            for (std::size_t slot = node.first; slot < std::size_t{node.first} + node.count; ++slot) {
                const std::uint32_t primitive = bvh_.primitive_ids[slot];
                if (is_inactive_primitive(primitives_, primitive)) {
                    return name_node(index) + ": " + name_primitive(primitive) + " is inactive";
                }
                expected = merge(expected, primitive_bounds(primitives_, primitive));
            }
        } else {
            expected = merge(bvh_.nodes[node.first].bounds(), bvh_.nodes[std::size_t{node.first} + 1].bounds());
        }
        // As floats, not as bytes: a box that starts at -0 equals one that starts at +0.
        const Aabb box = node.bounds();
        if (node.is_leaf() && bvh_.split_references) {
            if (lies_within(box, expected)) return {};
            return name_node(index) + ": its box is not within the union of its primitives";
        }
        if (box == expected) return {};
        return name_node(index) + ": its box is not the union of its " + (node.is_leaf() ? "primitives" : "children");
    }

    /// Inactive primitives are known to be absent, so a count tells whether an active one is.
    std::string find_missing_primitive() const {
        if (primitives_reached_ + inactive_ == count_) return {};
        std::size_t missing = 0;
        while (is_inactive_primitive(primitives_, missing) ||
               (!leaf_of_primitive_.empty() && leaf_of_primitive_[missing] != kNone))
            ++missing;
        return name_primitive(missing) + " is in no leaf";
    }

    std::string check_coverage() const {
        std::vector<std::uint32_t> leaves;
        std::ranges::copy_if(order_, std::back_inserter(leaves),
                             [&](std::uint32_t node) { return bvh_.nodes[node].is_leaf(); });
        const std::optional<LostPart> lost = find_lost_part(bvh_, primitives_, leaves);
        if (!lost) return {};
        std::ostringstream message;
        message << name_primitive(lost->primitive) << ": the part of it around (" << lost->point.x << ", "
                << lost->point.y << ", " << lost->point.z << ") is in none of the leaves that name it";
        return message.str();
    }

    const Bvh& bvh_;
    Primitives primitives_;
    std::uint64_t count_;  ///< Of primitives.
    ValidationReport report_;
    std::uint64_t inactive_ = 0;
    std::uint64_t primitives_reached_ = 0;
    std::vector<std::uint32_t> order_;              ///< Visited nodes in traversal order.
    std::vector<std::uint32_t> leaf_of_primitive_;  ///< One per primitive: the last leaf that named it, or kNone.
    std::vector<bool> id_reached_;                  ///< One per primitive id: is in a leaf; of split references only.
};

}  // namespace

ValidationReport validate(const Bvh& bvh, const Primitives& primitives) {
    return in_own_group([&] { return Validator(bvh, primitives).run(); });
}

}  // namespace clbvh
