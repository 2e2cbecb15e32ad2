#include "scalar/hit_bytes.hpp"

#include <cstddef>

#include "clbvh/host/median.hpp"
#include "clbvh/trace/tracer.hpp"

namespace clbvh::test {
namespace {

template <typename Value>
void append(std::vector<std::uint8_t>& bytes, const Value& value) {
    const auto* const first = reinterpret_cast<const std::uint8_t*>(&value);
    bytes.insert(bytes.end(), first, first + sizeof(Value));
}

}  // namespace

std::vector<std::uint8_t> hit_bytes(const std::vector<float>& triangles, const std::vector<float>& rays) {
    Mesh mesh;
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i + 8 < triangles.size(); i += 9) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (std::size_t corner = i; corner < i + 9; corner += 3)
            mesh.vertices.push_back({triangles[corner], triangles[corner + 1], triangles[corner + 2]});
        mesh.triangles.push_back({first, first + 1, first + 2});
        boxes.push_back(triangle_bounds(mesh, mesh.triangles.size() - 1));
    }
    const Bvh bvh = build_median(boxes);
    std::vector<std::uint8_t> bytes;
    for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
        const Tracer tracer(bvh, mesh, {test});
        for (std::size_t i = 0; i + 7 < rays.size(); i += 8) {
            const float* const r = &rays[i];
            const Ray ray{{r[0], r[1], r[2]}, r[3], {r[4], r[5], r[6]}, r[7]};
            RayCounts counts;
            append(bytes, tracer.closest(ray));
            append(bytes, tracer.any(ray));
            append(bytes, tracer.closest(ray, counts));
            append(bytes, counts);
            append(bytes, tracer.visits(ray));
        }
    }
    return bytes;
}

}  // namespace clbvh::test
