#pragma once

#include <span>

#include "clbvh/core/mesh.hpp"
#include "core/scratch.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// Writes a reference for each active triangle, in the order of their ids. `references` has exactly as many elements.
/// Returns the bounds of all.
Bounds bound_primitives(const Mesh& mesh, std::span<Reference> references, Scratch& scratch);

/// Writes a reference for each box; the spans are of one size. Returns the bounds of all.
Bounds copy_boxes(std::span<const Aabb> boxes, std::span<Reference> references);

/// Throws Error(invalid_input) naming the first box that has a NaN, is inverted or lies beyond kMaxCoordinate.
void check_boxes(std::span<const Aabb> bounds);

}  // namespace clbvh::host
