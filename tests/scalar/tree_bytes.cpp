#include "scalar/tree_bytes.hpp"

#include "clbvh/core/error.hpp"
#include "clbvh/host/aac.hpp"
#include "clbvh/host/binned_sah.hpp"
#include "clbvh/host/collapse.hpp"
#include "clbvh/host/locally_ordered.hpp"
#include "clbvh/host/median.hpp"
#include "clbvh/host/sbvh.hpp"
#include "clbvh/host/sweep_sah.hpp"

namespace clbvh::test {
namespace {

Mesh mesh_of(const std::vector<float>& triangles) {
    Mesh mesh;
    for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
        mesh.vertices.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    for (std::uint32_t i = 0; i + 2 < mesh.vertices.size(); i += 3)
        mesh.triangles.push_back({i, i + 1, i + 2});
    return mesh;
}

Bvh build(std::string_view id, const Mesh& mesh) {
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        boxes.push_back(triangle_bounds(mesh, i));
    if (id == "binned-sah") return build_binned_sah(boxes);
    if (id == "sweep-sah") return build_sweep_sah(boxes);
    if (id == "sbvh") return build_sbvh(mesh);
    if (id == "aac-hq") return build_aac(boxes, AacConfig::hq());
    if (id == "aac-fast") return build_aac(boxes, AacConfig::fast());
    if (id == "locally-ordered") return build_locally_ordered(boxes);
    if (id == "median") return build_median(boxes);
    throw Error(ErrorCode::invalid_input, "tree_bytes() does not know this builder");
}

template <typename Element>
void append(std::vector<std::uint8_t>& bytes, const std::vector<Element>& elements) {
    const auto* const first = reinterpret_cast<const std::uint8_t*>(elements.data());
    bytes.insert(bytes.end(), first, first + elements.size() * sizeof(Element));
}

}  // namespace

std::vector<std::uint8_t> tree_bytes(std::string_view id, const std::vector<float>& triangles) {
    const Bvh bvh = collapse(build(id, mesh_of(triangles)));
    std::vector<std::uint8_t> bytes;
    append(bytes, bvh.nodes);
    append(bytes, bvh.primitive_ids);
    return bytes;
}

}  // namespace clbvh::test
