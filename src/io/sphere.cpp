#include "io/sphere.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace clbvh::io {
namespace {

/// A closed sphere: an octahedron whose faces are cut into n^2 triangles each, in rings of vertices around the y axis.
///
///         0            ring 0: the pole
///       / | \ .        ring r: 4 * min(r, 2n - r) vertices
///      1--2--3..       between rings r and r + 1: four sectors of a strip each
class SphereMaker {
public:
    SphereMaker(Mesh& mesh, std::uint32_t n) : mesh_(mesh), n_(n) {}

    void make() {
        for (std::uint32_t ring = 0; ring <= 2 * n_; ++ring)
            push_ring(ring);
        std::uint32_t upper = 0;
        for (std::uint32_t ring = 0; ring < 2 * n_; ++ring) {
            const std::uint32_t lower = upper + vertices_in(ring);
            for (std::uint32_t sector = 0; sector < 4; ++sector)
                push_strip(ring, sector, upper, lower);
            upper = lower;
        }
    }

    /// Splits a triangle in three around its centre, which keeps the surface closed.
    void split(std::size_t triangle) {
        const auto [a, b, c] = mesh_.triangles[triangle];
        const Vec3& p = mesh_.vertices[a];
        const Vec3& q = mesh_.vertices[b];
        const Vec3& r = mesh_.vertices[c];
        const std::uint32_t centre = push_projected(p.x + q.x + r.x, p.y + q.y + r.y, p.z + q.z + r.z);
        mesh_.triangles[triangle] = {a, b, centre};
        mesh_.triangles.push_back({b, c, centre});
        mesh_.triangles.push_back({c, a, centre});
    }

private:
    /// Edges that a ring has in each of the four sectors.
    [[nodiscard]] std::uint32_t width_of(std::uint32_t ring) const { return std::min(ring, 2 * n_ - ring); }
    [[nodiscard]] std::uint32_t vertices_in(std::uint32_t ring) const { return std::max(1U, 4 * width_of(ring)); }

    /// IEEE 754 rounds square roots and divisions the same way everywhere; sines it does not.
    std::uint32_t push_projected(double x, double y, double z) {
        const double length = std::sqrt(x * x + y * y + z * z);
        mesh_.vertices.push_back(
            {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)});
        return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
    }

    void push_ring(std::uint32_t ring) {
        constexpr int kTurn[5] = {1, 0, -1, 0, 1};
        const std::uint32_t width = width_of(ring);
        const double height = static_cast<double>(n_) - ring;
        for (std::uint32_t i = 0; i < vertices_in(ring); ++i) {
            const std::uint32_t sector = width == 0 ? 0 : i / width;
            const double done = width == 0 ? 0 : i % width;
            const double left = width - done;
            push_projected(left * kTurn[sector] + done * kTurn[sector + 1], height,
                           left * kTurn[(sector + 3) % 4] + done * kTurn[sector]);
        }
    }

    void push_strip(std::uint32_t ring, std::uint32_t sector, std::uint32_t upper, std::uint32_t lower) {
        const auto vertex = [sector](std::uint32_t start, std::uint32_t width, std::uint32_t i) {
            return start + (width == 0 ? 0 : (sector * width + i) % (4 * width));
        };
        const std::uint32_t above = width_of(ring);
        const std::uint32_t below = width_of(ring + 1);
        for (std::uint32_t i = 0; i < std::max(above, below); ++i) {
            const bool widens = below > above;
            if (i < below) {
                mesh_.triangles.push_back(
                    {vertex(upper, above, widens ? i : i + 1), vertex(lower, below, i + 1), vertex(lower, below, i)});
            }
            if (i < above) {
                mesh_.triangles.push_back(
                    {vertex(upper, above, i), vertex(upper, above, i + 1), vertex(lower, below, widens ? i + 1 : i)});
            }
        }
    }

    Mesh& mesh_;
    std::uint32_t n_;
};

}  // namespace

Mesh make_sphere(std::uint64_t count) {
    std::uint32_t n = 1;
    while (8 * (n + 1ULL) * (n + 1ULL) <= count)
        ++n;
    Mesh mesh;
    mesh.vertices.reserve(count / 2 + 3);
    mesh.triangles.reserve(count + 2);
    SphereMaker sphere(mesh, n);
    sphere.make();
    for (std::size_t i = 0; mesh.triangles.size() < count; ++i)
        sphere.split(i);
    mesh.triangles.resize(count);
    return mesh;
}

}  // namespace clbvh::io
