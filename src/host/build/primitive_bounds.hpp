#pragma once

#include <span>

#include "clbvh/core/primitives.hpp"
#include "core/scratch.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host {

/// Writes a reference for each active primitive, in the order of their ids. `references` has exactly as many elements.
/// Returns the bounds of all.
Bounds bound_primitives(const Primitives& primitives, std::span<Reference> references, Scratch& scratch);

}  // namespace clbvh::host
