// A fuzzer for what cuts polygons: two bytes a corner. There are as many triangles as corners less two, their signed
// areas make the polygon's, and a cut that says that it is clean covers no more.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <vector>

#include "io/read/polygon.hpp"

namespace {

double turned(const clbvh::Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const clbvh::Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    return (double{q.x} - p.x) * (double{r.y} - p.y) - (double{q.y} - p.y) * (double{r.x} - p.x);
}

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    clbvh::Mesh mesh;
    for (std::size_t i = 0; i + 1 < size; i += 2)
        mesh.vertices.push_back({static_cast<float>(data[i]), static_cast<float>(data[i + 1]), 65536.0f});
    std::vector<std::uint32_t> corners(mesh.vertices.size());
    if (corners.size() < 3) return 0;
    std::iota(corners.begin(), corners.end(), 0U);
    const clbvh::io::PolygonCut cut = clbvh::io::append_polygon(corners, mesh);
    require(mesh.triangles.size() == corners.size() - 2);
    double whole = 0.0, sum = 0.0, covered = 0.0;  // sums of whole numbers, and exact
    for (std::size_t i = 2; i < corners.size(); ++i)
        whole += turned(mesh, corners[0], corners[i - 1], corners[i]);
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += turned(mesh, a, b, c);
        covered += std::abs(turned(mesh, a, b, c));
    }
    require(sum == whole);
    require(cut == clbvh::io::PolygonCut::fan || covered == std::abs(whole));
    return 0;
}
