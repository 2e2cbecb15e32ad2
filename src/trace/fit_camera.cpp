#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "clbvh/core/mesh_bounds.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/trace/camera.hpp"
#include "core/random.hpp"

namespace clbvh {
namespace {

/// Two directions at right angles to `up` and to each other.
struct Horizon {
    Vec3 side;
    Vec3 ahead;

    explicit Horizon(const Vec3& up) {
        side = std::abs(up.x) > 0.5f ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
        ahead = cross(up, side);
    }
};

/// A unit vector by its angle with the horizon; (cosine, sine) is where it looks along it.
Vec3 towards(const Horizon& horizon, const Vec3& up, float cosine, float sine, float rise) {
    return normalized((horizon.side * cosine + horizon.ahead * sine) + up * rise);
}

Vec3 inside_at(const Aabb& box, const Vec3& part) {
    const Vec3 size = box.upper - box.lower;
    return {box.lower.x + part.x * size.x, box.lower.y + part.y * size.y, box.lower.z + part.z * size.z};
}

Vec3 random_direction(Random& random) {
    Vec3 direction;
    do {
        direction = random.in_cube(-1.0f, 1.0f);
    } while (dot(direction, direction) > 1.0f || dot(direction, direction) < 1e-4f);
    return normalized(direction);
}

std::vector<Hit> hits_of(const ClosestHits& trace, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    trace(rays, hits);
    return hits;
}

/// True where almost every point of the box is surrounded by surfaces: that is so in a room, and is not around an
/// object, whose box has corners outside it.
bool is_closed_around(const Aabb& box, const ClosestHits& trace) {
    constexpr std::size_t points = 256;
    constexpr std::size_t rays_per_point = 64;
    constexpr std::size_t enclosed_at_least = rays_per_point * 7 / 10;
    Random random(1);
    std::vector<Ray> rays(points * rays_per_point);
    for (std::size_t p = 0; p < points; ++p) {
        const Vec3 origin = inside_at(box, random.in_cube(0.05f, 0.95f));
        for (std::size_t i = 0; i < rays_per_point; ++i) {
            rays[p * rays_per_point + i].origin = origin;
            rays[p * rays_per_point + i].direction = random_direction(random);
        }
    }
    const std::vector<Hit> hits = hits_of(trace, rays);
    std::size_t enclosed = 0;
    for (std::size_t p = 0; p < points; ++p) {
        const auto first = hits.begin() + static_cast<std::ptrdiff_t>(p * rays_per_point);
        const auto count = std::count_if(first, first + rays_per_point, [](const Hit& hit) { return bool(hit); });
        if (static_cast<std::size_t>(count) >= enclosed_at_least) ++enclosed;
    }
    return enclosed * 10 >= points * 8;
}

/// Three quarters from the front, and a little from above.
Camera view_from_outside(const Aabb& box, const Vec3& up) {
    constexpr float rise = 0.45f;
    constexpr float field_of_view = 35.0f;
    constexpr float distance = 1.45f;  // in diagonals of the box
    const Horizon horizon(up);
    const Vec3 centre = inside_at(box, {0.5f, 0.5f, 0.5f});
    // A point gets some distance too, of which its coordinates can tell.
    const float diagonal = std::max({length(box.upper - box.lower), 1e-5f * length(centre), 1e-30f});
    const Vec3 way = towards(horizon, up, 0.55f, -0.85f, rise);
    return {centre + way * (distance * diagonal), centre, up, field_of_view};
}

/// How much there is to see in a view, of the hits of a small picture.
double worth(const std::vector<Hit>& hits, std::size_t begin, std::size_t count, float diagonal) {
    std::vector<std::uint32_t> seen;
    double depth = 0.0;
    for (std::size_t i = begin; i < begin + count; ++i) {
        if (!hits[i]) continue;
        seen.push_back(hits[i].primitive);
        // Something close by hides the rest.
        const float part = hits[i].t / diagonal;
        depth += part < 0.06f ? -1.0 : std::min(std::sqrt(static_cast<double>(part)), 0.8);
    }
    std::ranges::sort(seen);
    const auto distinct = static_cast<double>(std::ranges::unique(seen).begin() - seen.begin());
    return (depth + 0.8 * distinct) / static_cast<double>(count);
}

/// The best of many views from inside.
Camera view_from_inside(const Aabb& box, const Vec3& up, const ClosestHits& trace) {
    constexpr std::uint32_t width = 16;
    constexpr std::uint32_t height = 9;
    constexpr std::size_t places = 96;
    constexpr std::array<std::array<float, 2>, 8> directions{
        {{1, 0}, {0.7f, 0.7f}, {0, 1}, {-0.7f, 0.7f}, {-1, 0}, {-0.7f, -0.7f}, {0, -1}, {0.7f, -0.7f}}};
    const Horizon horizon(up);
    const float diagonal = length(box.upper - box.lower);
    std::vector<Camera> cameras;
    std::vector<Ray> rays;
    Random random(2);
    for (std::size_t place = 0; place < places; ++place) {
        Vec3 part = random.in_cube(0.08f, 0.92f);
        const float eye_height = random.between(0.35f, 0.6f);
        for (float Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
            if (up.*axis != 0.0f) part.*axis = up.*axis > 0.0f ? eye_height : 1.0f - eye_height;
        }
        const Vec3 eye = inside_at(box, part);
        for (const auto& [cosine, sine] : directions) {
            const Vec3 ahead = towards(horizon, up, cosine, sine, -0.12f);
            cameras.push_back({eye, eye + ahead * (0.5f * diagonal), up, 60.0f});
            const CameraRays view(cameras.back(), 16.0f / 9.0f);
            for (std::uint32_t i = 0; i < width * height; ++i) {
                const auto x = static_cast<float>(i % width);
                const auto y = static_cast<float>(i / width);
                rays.push_back(view.at((x + 0.5f) / width, (y + 0.5f) / height));
            }
        }
    }
    const std::vector<Hit> hits = hits_of(trace, rays);
    std::vector<double> worths;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        worths.push_back(worth(hits, i * width * height, width * height, diagonal));
    return cameras[static_cast<std::size_t>(std::ranges::max_element(worths) - worths.begin())];
}

/// Area of the triangles that face along the axis, within some 8 degrees.
struct FacingArea {
    double y = 0.0;
    double z = 0.0;
};

FacingArea facing_area(const Mesh& mesh) {
    constexpr double cosine = 0.99;
    FacingArea area;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (is_inactive(mesh, i)) continue;
        const Triangle& t = mesh.triangles[i];
        const Vec3 n = cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        const double y = std::abs(static_cast<double>(n.y));
        const double z = std::abs(static_cast<double>(n.z));
        const double norm = std::sqrt(static_cast<double>(n.x) * n.x + y * y + z * z);
        if (y > cosine * norm) area.y += norm;
        if (z > cosine * norm) area.z += norm;
    }
    return area;
}

}  // namespace

Vec3 guess_up(const Mesh& mesh) {
    const FacingArea area = facing_area(mesh);
    return area.z > 1.5 * area.y ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
}

Camera fit_camera(const Mesh& mesh, const Vec3& up, const ClosestHits& trace) {
    const Aabb box = mesh_bounds(mesh);
    if (!(box.lower.x <= box.upper.x)) return {{0, 0, 1}, {0, 0, 0}, up, 45.0f};
    return is_closed_around(box, trace) ? view_from_inside(box, up, trace) : view_from_outside(box, up);
}

}  // namespace clbvh
