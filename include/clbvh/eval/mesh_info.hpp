#pragma once

#include <cstdint>

#include "clbvh/core/aabb.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// What there is to say of a mesh before a tree is built over it. A triangle is of one of the first three kinds, or
/// sound.
struct MeshInfo {
    std::uint64_t vertices = 0;   ///< Those that no triangle uses included.
    std::uint64_t triangles = 0;  ///< All of them.
    std::uint64_t out_of_range =
        0;                       ///< With a coordinate that is infinite or beyond kMaxCoordinate: builders refuse them.
    std::uint64_t inactive = 0;  ///< With a coordinate that is NaN: in no tree.
    std::uint64_t zero_area = 0;   ///< With corners on a line or at a point: in trees, but no ray hits them.
    std::uint64_t duplicates = 0;  ///< Of the last two kinds: the corners are those of an earlier one, in any order.
    double area = 0.0;             ///< Of those that are not out of range or inactive.
    Aabb bounds;                   ///< Of the same; empty where there are none.
};

/// Looks at every triangle. Throws Error(invalid_input) that names the first triangle with an index out of range, and
/// std::bad_alloc.
[[nodiscard]] CLBVH_EVAL_API MeshInfo mesh_info(const MeshView& mesh);

}  // namespace clbvh
