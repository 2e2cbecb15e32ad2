#pragma once

#include <clbvh/core/mesh.hpp>
#include <clbvh/core/ray.hpp>
#include <cstdint>
#include <vector>

namespace clbvh::tool {

/// How the surfaces of a mesh look, which has no materials itself: round where triangles meet at flat angles, and in
/// muted colours, one for each connected part of the mesh. Large parts are light; their floors are darker.
class SurfaceLook {
public:
    SurfaceLook(const Mesh& mesh, const Vec3& up);

    /// The normal to shade with at a hit, on the side of the triangle's own `normal`.
    [[nodiscard]] Vec3 shading_normal(const Hit& hit, const Vec3& normal) const;
    /// The part of the light that is sent back, by colour.
    [[nodiscard]] Vec3 albedo(const Hit& hit, const Vec3& normal) const;

private:
    void weld();
    void smooth();
    void tint();

    const Mesh& mesh_;
    Vec3 up_;
    std::vector<std::uint32_t> welded_;  // of each vertex: the first one at the same place
    std::vector<Vec3> normals_;          // of welded vertices; zero where there is none
    std::vector<std::uint8_t> tints_;    // of welded vertices
};

}  // namespace clbvh::tool
