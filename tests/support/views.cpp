#include "support/views.hpp"

#include <limits>
#include <utility>

#include "clbvh/io/scene.hpp"

namespace clbvh::test {
namespace {

constexpr float kGap = std::numeric_limits<float>::infinity();  // no check lets it through

void set_vertices(ViewedMesh& target, const std::vector<Vec3>& vertices, std::uint32_t stride, std::size_t offset) {
    const std::size_t step = stride / sizeof(float);
    target.vertices.assign(offset + vertices.size() * step, kGap);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        float* const v = &target.vertices[offset + i * step];
        v[0] = vertices[i].x;
        v[1] = vertices[i].y;
        v[2] = vertices[i].z;
    }
    target.vertices.resize(target.vertices.size() - (step - 3));  // nothing behind the last
    target.view.vertices = target.vertices.data() + offset;
    target.view.vertex_count = vertices.size();
    target.view.vertex_stride = stride;
}

/// `gap` indices between the triangles'.
template <typename Index>
void set_indices(ViewedMesh& target, std::vector<Index>& indices, const Mesh& mesh, std::size_t gap) {
    for (const Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t index : triangle)
            indices.push_back(static_cast<Index>(index));
        indices.insert(indices.end(), gap, static_cast<Index>(~0u));
    }
    indices.resize(indices.size() - gap);
    target.view.indices = indices.data();
    target.view.triangle_count = mesh.triangles.size();
    target.view.index_type = sizeof(Index) == 2 ? IndexType::uint16 : IndexType::uint32;
    target.view.index_stride = gap > 0 ? static_cast<std::uint32_t>((3 + gap) * sizeof(Index)) : 0;
}

std::vector<Vec3> one_by_one(const Mesh& mesh) {
    std::vector<Vec3> vertices;
    for (const Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t index : triangle)
            vertices.push_back(mesh.vertices[index]);
    }
    return vertices;
}

}  // namespace

Mesh mesh_with_inactive() {
    Mesh mesh = generate_scene("hair", 1500);
    mesh.vertices[100].y = std::numeric_limits<float>::quiet_NaN();
    mesh.vertices[701].z = std::numeric_limits<float>::quiet_NaN();
    return mesh;
}

std::vector<Ray> rays_to_vertices(const Aabb& box, const Mesh& mesh) {
    std::vector<Ray> rays;
    for (std::uint32_t i = 0; i < 200; ++i) {
        const Vec3 target = mesh.vertices[7 * i];
        rays.push_back({{box.lower.x - 1, box.lower.y - 2, box.lower.z - 3},
                        0,
                        {target.x - box.lower.x + 1, target.y - box.lower.y + 2, target.z - box.lower.z + 3}});
    }
    return rays;
}

std::vector<ViewedMesh> layouts_of(const Mesh& mesh) {
    std::vector<ViewedMesh> layouts;
    for (const auto& [stride, offset] :
         {std::pair{12u, 0u}, std::pair{12u, 1u}, std::pair{16u, 0u}, std::pair{20u, 2u}, std::pair{24u, 3u}}) {
        const std::string name =
            "vertices every " + std::to_string(stride) + " bytes from " + std::to_string(4 * offset);
        for (const std::size_t gap : {std::size_t{0}, std::size_t{1}}) {
            ViewedMesh& target = layouts.emplace_back();
            target.name = name + ", 32-bit indices, " + std::to_string(gap) + " between";
            set_vertices(target, mesh.vertices, stride, offset);
            set_indices(target, target.indices, mesh, gap);
            if (mesh.vertices.size() > 65536) continue;
            ViewedMesh& small = layouts.emplace_back();
            small.name = name + ", 16-bit indices, " + std::to_string(gap) + " between";
            set_vertices(small, mesh.vertices, stride, offset);
            set_indices(small, small.short_indices, mesh, gap);
        }
        ViewedMesh& loose = layouts.emplace_back();
        loose.name = name + ", no indices";
        set_vertices(loose, one_by_one(mesh), stride, offset);
        loose.view.triangle_count = mesh.triangles.size();
    }
    return layouts;
}

std::vector<ViewedBoxes> layouts_of(const std::vector<Aabb>& boxes) {
    std::vector<ViewedBoxes> layouts;
    for (const std::uint32_t stride : {24u, 28u, 32u}) {
        ViewedBoxes& target = layouts.emplace_back();
        target.name = "boxes every " + std::to_string(stride) + " bytes";
        const std::size_t step = stride / sizeof(float);
        target.floats.assign(boxes.size() * step, kGap);
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            float* b = &target.floats[i * step];
            const auto& [lower, upper] = boxes[i];
            for (const float value : {lower.x, lower.y, lower.z, upper.x, upper.y, upper.z})
                *b++ = value;
        }
        target.view = BoxView(target.floats.data(), boxes.size(), stride);
    }
    return layouts;
}

}  // namespace clbvh::test
