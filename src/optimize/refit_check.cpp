#include "optimize/refit_check.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/primitive_access.hpp"

namespace clbvh::optimizer {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_input, what);
}

/// Which primitives the tree's leaves name.
std::vector<bool> named_primitives(const Bvh& tree) {
    std::vector<bool> named(tree.primitive_count);
    for (const std::uint32_t id : tree.primitive_ids) {
        if (id >= named.size()) refuse("the tree names primitive " + std::to_string(id) + ", which it cannot have");
        named[id] = true;
    }
    return named;
}

}  // namespace

void check_same_primitives(const Bvh& tree, const Primitives& primitives) {
    const std::string one = std::holds_alternative<MeshView>(primitives) ? "triangle " : "box ";
    if (count_of(primitives) != tree.primitive_count) {
        refuse(count_in_words(primitives) + ", but the tree was built over " + std::to_string(tree.primitive_count) +
               "; build anew");
    }
    const std::uint64_t inactive = check_primitives(primitives);
    // The common case; duplicates and holes among the ids would need a broken tree.
    if (inactive == 0 && !tree.split_references && tree.primitive_ids.size() == tree.primitive_count) return;
    const std::vector<bool> named = named_primitives(tree);
    for (std::size_t i = 0; i < named.size(); ++i) {
        if (named[i] != is_inactive_primitive(primitives, i)) continue;
        refuse(one + std::to_string(i) + (named[i] ? " has a NaN now, but is" : " had a NaN, and is not") +
               " in the tree; build anew");
    }
}

}  // namespace clbvh::optimizer
