#include "layout/leaf_check.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <sstream>

#include "clbvh/core/error.hpp"
#include "core/coverage.hpp"
#include "core/primitive_access.hpp"
#include "core/tree_walk.hpp"

namespace clbvh::layout {

void reject_layout(const std::string& fault) {
    throw Error(ErrorCode::invalid_input, "the layout is not valid: " + fault + "; make it anew from a valid tree");
}

void reject_unused(const std::vector<bool>& used, const char* what) {
    const auto unused = std::ranges::find(used, false);
    if (unused != used.end())
        reject_layout(std::string(what) + " " + std::to_string(unused - used.begin()) + " is not part of the tree");
}

void check_depth(std::size_t stated, std::size_t found) {
    if (stated != found) reject_layout("depth is " + std::to_string(stated) + " where it is " + std::to_string(found));
}

bool contains(const Aabb& outer, const Aabb& inner) noexcept {
    return outer.lower.x <= inner.lower.x && outer.lower.y <= inner.lower.y && outer.lower.z <= inner.lower.z &&
           outer.upper.x >= inner.upper.x && outer.upper.y >= inner.upper.y && outer.upper.z >= inner.upper.z;
}

LeafCheck::LeafCheck(const Primitives& primitives, std::uint64_t primitive_count, bool split_references,
                     bool joins_leaves)
    : primitives_(primitives),
      count_(count_of(primitives)),
      inactive_(check_primitives(primitives)),
      split_references_(split_references),
      may_repeat_(split_references && joins_leaves),
      last_leaf_(count_, 0) {
    if (primitive_count == count_) return;
    reject_layout("primitive_count is " + std::to_string(primitive_count) + ", but " + count_in_words(primitives));
}

const char* LeafCheck::find_fault(std::size_t leaf, const Aabb& box, std::uint32_t id) const {
    if (id >= count_) return "is out of range";
    if (last_leaf_[id] == leaf + 1 && !may_repeat_) return "is in this leaf a second time";
    if (last_leaf_[id] != 0 && !split_references_) return "is in the tree a second time";
    if (is_inactive_primitive(primitives_, id)) return "is inactive";
    if (!split_references_ && !contains(box, primitive_bounds(primitives_, id))) return "is not within the leaf's box";
    return nullptr;
}

void LeafCheck::add(std::size_t node, const Aabb& box, std::span<const std::uint32_t> ids, std::size_t slot) {
    const std::size_t leaf = 8 * node + slot;
    const std::size_t first = leaves_.primitive_ids.size();
    for (const std::uint32_t id : ids) {
        if (const char* const fault = find_fault(leaf, box, id); fault != nullptr)
            reject_layout(name_node(node) + ": primitive " + std::to_string(id) + " " + fault);
        if (last_leaf_[id] == 0) ++reached_;
        if (split_references_ && last_leaf_[id] != leaf + 1) leaves_.primitive_ids.push_back(id);
        last_leaf_[id] = leaf + 1;
    }
    if (!split_references_) return;
    leaves_.nodes.push_back({{box.lower.x, box.lower.y, box.lower.z},
                             static_cast<std::uint32_t>(first),
                             {box.upper.x, box.upper.y, box.upper.z},
                             static_cast<std::uint32_t>(leaves_.primitive_ids.size() - first)});
}

void LeafCheck::finish() {
    if (reached_ + inactive_ != count_) {
        std::size_t missing = 0;
        while (last_leaf_[missing] != 0 || is_inactive_primitive(primitives_, missing))
            ++missing;
        reject_layout("primitive " + std::to_string(missing) + " is in no leaf");
    }
    if (!split_references_) return;
    leaves_.primitive_count = count_;
    leaves_.split_references = true;
    std::vector<std::uint32_t> all(leaves_.nodes.size());
    std::iota(all.begin(), all.end(), 0U);
    const std::optional<LostPart> lost = find_lost_part(leaves_, primitives_, all);
    if (!lost) return;
    std::ostringstream message;
    message << "primitive " << lost->primitive << ": the part of it around (" << lost->point.x << ", " << lost->point.y
            << ", " << lost->point.z << ") is in none of the leaves that name it";
    reject_layout(message.str());
}

}  // namespace clbvh::layout
