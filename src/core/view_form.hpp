#pragma once

#include "clbvh/core/primitives.hpp"

namespace clbvh {

/// Throws Error(invalid_input) where the view's pointers are null or not aligned, or its strides or counts do not go
/// together. Reads nothing that it points to.
void check_form(const MeshView& mesh);
void check_form(const BoxView& boxes);

}  // namespace clbvh
