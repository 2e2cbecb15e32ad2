#pragma once

#include <clbvh/core/mesh.hpp>
#include <vector>

namespace clbvh::tool {

/// A copy of the mesh's vertices with one more behind them: Embree reads vertices 16 bytes at a time.
[[nodiscard]] inline std::vector<Vec3> padded_vertices(const Mesh& mesh) {
    std::vector<Vec3> copy;
    copy.reserve(mesh.vertices.size() + 1);
    copy = mesh.vertices;
    copy.emplace_back();
    return copy;
}

}  // namespace clbvh::tool
