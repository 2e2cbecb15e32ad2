#pragma once

#include <array>

#include "clbvh/core/primitives.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/layout_array.hpp"
#include "clbvh/layout/make_layout.hpp"

namespace clbvh {

/// The vertices of one triangle; 48 bytes, little-endian: three times float32 x y z and a 0, as kernels read them that
/// take vertices as float4, three for each primitive.
struct PaddedTriangle {
    std::array<std::array<float, 4>, 3> vertices;
};
static_assert(sizeof(PaddedTriangle) == 48);

/// Triangle i is primitive i, inactive ones included. Throws what check_mesh does, and Error(out_of_memory). `result`
/// is then empty.
CLBVH_API void make_padded_triangles(const MeshView& mesh, LayoutArray<PaddedTriangle>& result,
                                     const LayoutOptions& options = {});

}  // namespace clbvh
