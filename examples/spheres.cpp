// Rays through a tree over primitives of the caller's own: spheres, drawn with characters. No mesh, no OpenCL device.

#include <algorithm>
#include <clbvh/clbvh.hpp>
#include <cmath>
#include <iostream>
#include <optional>
#include <string_view>
#include <vector>

namespace {

struct Sphere {
    clbvh::Vec3 centre;
    float radius;
};

/// Where the ray, whose direction has length 1, enters the sphere, if that is before t_max.
std::optional<float> enter(const Sphere& sphere, const clbvh::Ray& ray, float t_max) {
    const clbvh::Vec3 &c = sphere.centre, &o = ray.origin, &d = ray.direction;
    const clbvh::Vec3 to{c.x - o.x, c.y - o.y, c.z - o.z};
    const float along = to.x * d.x + to.y * d.y + to.z * d.z;
    const float beside2 = to.x * to.x + to.y * to.y + to.z * to.z - along * along;
    const float half_chord2 = sphere.radius * sphere.radius - beside2;
    if (half_chord2 < 0.0f) return std::nullopt;
    const float t = along - std::sqrt(half_chord2);
    if (t < ray.t_min || t > t_max) return std::nullopt;
    return t;
}

}  // namespace

int main() {
    // A shell: points of a spiral from pole to pole.
    std::vector<Sphere> spheres;
    std::vector<clbvh::Aabb> boxes;
    for (int i = 0; i < 400; ++i) {
        const float z = (static_cast<float>(i) + 0.5f) / 200.0f - 1.0f, turn = 2.4f * static_cast<float>(i);
        const float ring = std::sqrt(1.0f - z * z), r = 0.09f;
        const clbvh::Vec3 c{ring * std::cos(turn), ring * std::sin(turn), z};
        spheres.push_back({c, r});
        boxes.push_back({{c.x - r, c.y - r, c.z - r}, {c.x + r, c.y + r, c.z + r}});
    }
    try {
        const clbvh::Bvh bvh = clbvh::build_sweep_sah(boxes);
        clbvh::RayCounts counts;
        std::size_t tested = 0;
        for (int row = 0; row < 30; ++row) {
            for (int column = 0; column < 60; ++column) {
                const float x = static_cast<float>(column) / 25.0f - 1.2f, y = 1.2f - static_cast<float>(row) / 12.5f;
                const clbvh::Ray ray{{x, y, -3.0f}, 0.0f, {0.0f, 0.0f, 1.0f}};
                float depth = 5.0f;
                // Called for every leaf that the ray meets, near ones first; t_max is where the ray ends now.
                const auto find_closest = [&](std::uint32_t first, std::uint32_t count, float& t_max) {
                    for (std::uint32_t i = first; i < first + count; ++i) {
                        ++tested;
                        const std::optional<float> t = enter(spheres[bvh.primitive_ids[i]], ray, t_max);
                        if (t) depth = t_max = *t;
                    }
                    return true;  // go on
                };
                clbvh::traverse(bvh.nodes, ray, find_closest, counts);
                constexpr std::string_view shades = "@%#*+=-:. ";
                const float shade = std::clamp((depth - 1.9f) / 2.2f, 0.0f, 1.0f) * 9.0f;
                std::cout << shades[static_cast<std::size_t>(shade)];
            }
            std::cout << '\n';
        }
        std::cout << "1800 rays, 400 spheres: " << counts.inner_nodes << " inner nodes visited, " << tested
                  << " spheres tested\n";
        return 0;
    } catch (const clbvh::Error& error) {
        std::cerr << "spheres: " << error.what() << '\n';
        return 1;
    }
}
