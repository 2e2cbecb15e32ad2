#include "support/fitted_by_definition.hpp"

#include <functional>

#include "core/primitive_access.hpp"

namespace clbvh::test {

Bvh fitted_by_definition(Bvh tree, const Primitives& primitives) {
    const std::function<Aabb(std::uint32_t)> fit = [&](std::uint32_t index) {
        Node& node = tree.nodes[index];
        Aabb box;
        if (node.is_leaf()) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                box = merge(box, primitive_bounds(primitives, tree.primitive_ids[i]));
        } else {
            box = merge(fit(node.first), fit(node.first + 1));
        }
        node = {{box.lower.x + 0.0f, box.lower.y + 0.0f, box.lower.z + 0.0f},
                node.first,
                {box.upper.x + 0.0f, box.upper.y + 0.0f, box.upper.z + 0.0f},
                node.count};
        return box;
    };
    if (!tree.empty()) fit(0);
    return tree;
}

}  // namespace clbvh::test
