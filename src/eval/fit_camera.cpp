#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "clbvh/core/mesh_bounds.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/eval/camera.hpp"
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

/// How free the view is around the points of a box.
struct Surroundings {
    std::size_t enclosed = 0;  ///< Points from which most rays hit something.
    std::size_t roomy = 0;     ///< Points from which half the rays go far.
};

constexpr std::size_t kSurveyedPoints = 256;

Surroundings survey(const Aabb& box, const ClosestHits& trace) {
    constexpr std::size_t rays_per_point = 64;
    const float far = 0.2f * length(box.upper - box.lower);
    Random random(1);
    std::vector<Ray> rays(kSurveyedPoints * rays_per_point);
    for (std::size_t p = 0; p < kSurveyedPoints; ++p) {
        const Vec3 origin = inside_at(box, random.in_cube(0.05f, 0.95f));
        for (std::size_t i = 0; i < rays_per_point; ++i) {
            rays[p * rays_per_point + i].origin = origin;
            rays[p * rays_per_point + i].direction = random_direction(random);
        }
    }
    const std::vector<Hit> hits = hits_of(trace, rays);
    Surroundings result;
    for (auto first = hits.begin(); first != hits.end(); first += rays_per_point) {
        const auto count = [&](const auto& is) { return std::count_if(first, first + rays_per_point, is); };
        if (count([](const Hit& hit) { return bool(hit); }) * 10 >= std::ptrdiff_t{rays_per_point} * 6)
            ++result.enclosed;
        if (count([&](const Hit& hit) { return hit.t >= far; }) * 2 >= std::ptrdiff_t{rays_per_point}) ++result.roomy;
    }
    return result;
}

/// True where almost all of the box is surrounded by surfaces, and a good part of it by nothing else: that is so in a
/// room, or in a court, but not around an object, whose box has corners outside it, and not in a car or in a thicket.
bool is_closed_around(const Aabb& box, const ClosestHits& trace) {
    const Surroundings surroundings = survey(box, trace);
    return surroundings.enclosed * 10 >= kSurveyedPoints * 8 && surroundings.roomy * 10 >= kSurveyedPoints * 2;
}

/// Three quarters from the front and a little from above, as near as the box's corners let it.
Camera view_from_outside(const Aabb& box, const Vec3& up) {
    constexpr float field_of_view = 35.0f;
    constexpr float half_height = 0.3f;  // of what is to hold the corners, at distance 1
    constexpr float half_width = 0.38f;
    const Horizon horizon(up);
    const Vec3 centre = inside_at(box, {0.5f, 0.5f, 0.5f});
    const Vec3 back = towards(horizon, up, 0.55f, -0.85f, 0.42f);
    const Vec3 right = normalized(cross(up, back));
    const Vec3 above = cross(back, right);
    // A point gets some distance too, of which its coordinates can tell.
    float distance = std::max({0.1f * length(box.upper - box.lower), 1e-5f * length(centre), 1e-30f});
    for (unsigned corner = 0; corner < 8; ++corner) {
        const Vec3 part{static_cast<float>(corner & 1U), static_cast<float>(corner >> 1U & 1U),
                        static_cast<float>(corner >> 2U & 1U)};
        const Vec3 way = inside_at(box, part) - centre;
        const float needed = std::max(std::abs(dot(way, right)) / half_width, std::abs(dot(way, above)) / half_height);
        distance = std::max(distance, needed + dot(way, back));
    }
    return {centre + back * distance, centre, up, field_of_view};
}

/// The small picture by which views are compared.
constexpr std::uint32_t kSketchWidth = 16;
constexpr std::uint32_t kSketchHeight = 9;
constexpr std::size_t kSketchPixels = std::size_t{kSketchWidth} * kSketchHeight;

void add_sketch(const Camera& camera, std::vector<Ray>& rays) {
    const CameraRays view(camera, static_cast<float>(kSketchWidth) / kSketchHeight);
    for (std::uint32_t y = 0; y < kSketchHeight; ++y) {
        for (std::uint32_t x = 0; x < kSketchWidth; ++x) {
            rays.push_back(
                view.at((static_cast<float>(x) + 0.5f) / kSketchWidth, (static_cast<float>(y) + 0.5f) / kSketchHeight));
        }
    }
}

bool is_central(std::size_t pixel) {
    const std::size_t x = pixel % kSketchWidth;
    const std::size_t y = pixel / kSketchWidth;
    return x >= 2 && x < kSketchWidth - 2 && y >= 1 && y < kSketchHeight - 1;
}

/// How much there is to see: depth and, not at the edges, different triangles.
double worth(std::span<const Hit> sketch, float diagonal) {
    std::vector<std::uint32_t> seen;
    double depth = 0.0;
    for (std::size_t i = 0; i < kSketchPixels; ++i) {
        if (!sketch[i]) continue;
        if (is_central(i)) seen.push_back(sketch[i].primitive);
        // Something close by hides the rest.
        const float part = sketch[i].t / diagonal;
        depth += part < 0.06f ? -1.0 : std::min(std::sqrt(static_cast<double>(part)), 0.8);
    }
    std::ranges::sort(seen);
    const auto repeated = std::unique(seen.begin(), seen.end());
    return depth + 1.5 * static_cast<double>(repeated - seen.begin());
}

/// Cameras all over the box at the height of eyes, each looking around.
std::vector<Camera> cameras_inside(const Aabb& box, const Vec3& up) {
    constexpr std::size_t places = 96;
    constexpr std::array<std::array<float, 2>, 8> directions{
        {{1, 0}, {0.7f, 0.7f}, {0, 1}, {-0.7f, 0.7f}, {-1, 0}, {-0.7f, -0.7f}, {0, -1}, {0.7f, -0.7f}}};
    const Horizon horizon(up);
    const float ahead = 0.5f * length(box.upper - box.lower);
    std::vector<Camera> cameras;
    Random random(2);
    for (std::size_t place = 0; place < places; ++place) {
        Vec3 part = random.in_cube(0.08f, 0.92f);
        const float eye_height = random.between(0.35f, 0.6f);
        for (float Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
            if (up.*axis != 0.0f) part.*axis = up.*axis > 0.0f ? eye_height : 1.0f - eye_height;
        }
        const Vec3 eye = inside_at(box, part);
        for (const auto& [cosine, sine] : directions) {
            for (const float rise : {-0.12f, -0.3f})
                cameras.push_back({eye, eye + towards(horizon, up, cosine, sine, rise) * ahead, up, 60.0f});
        }
    }
    return cameras;
}

Camera view_from_inside(const Aabb& box, const Vec3& up, const ClosestHits& trace) {
    const std::vector<Camera> cameras = cameras_inside(box, up);
    std::vector<Ray> rays;
    for (const Camera& camera : cameras)
        add_sketch(camera, rays);
    const std::vector<Hit> hits = hits_of(trace, rays);
    const float diagonal = length(box.upper - box.lower);
    std::vector<double> worths;
    for (std::size_t begin = 0; begin < hits.size(); begin += kSketchPixels)
        worths.push_back(worth(std::span(hits).subspan(begin, kSketchPixels), diagonal));
    return cameras[static_cast<std::size_t>(std::ranges::max_element(worths) - worths.begin())];
}

/// The box of the centroids of all triangles but the outermost at each side: where the detail is. Backdrops and ground
/// planes, large but few, may be outside it.
Aabb box_of_detail(const MeshView& mesh) {
    constexpr double left_out = 0.005;
    Aabb detail;
    std::vector<float> centres;
    for (float Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        centres.clear();
        for (std::size_t i = 0; i < mesh.triangle_count; ++i) {
            if (is_inactive(mesh, i)) continue;
            const Aabb box = triangle_bounds(mesh, i);
            centres.push_back(0.5f * (box.lower.*axis) + 0.5f * (box.upper.*axis));
        }
        const auto skip = static_cast<std::ptrdiff_t>(left_out * static_cast<double>(centres.size()));
        std::ranges::nth_element(centres, centres.begin() + skip);
        detail.lower.*axis = centres[static_cast<std::size_t>(skip)];
        std::ranges::nth_element(centres, centres.end() - 1 - skip);
        detail.upper.*axis = *(centres.end() - 1 - skip);
    }
    return detail;
}

/// The box, grown by the part of its size at each side but not beyond `limit`.
Aabb grown(const Aabb& box, float part, const Aabb& limit) {
    const Vec3 margin = (box.upper - box.lower) * part;
    return {max(box.lower - margin, limit.lower), min(box.upper + margin, limit.upper)};
}

/// How much of the mesh's surface faces along an axis, within some 8 degrees: areas in any unit.
struct FacingArea {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
    double all = 0.0;
};

FacingArea facing_area(const MeshView& mesh) {
    constexpr double cosine = 0.99;
    FacingArea area;
    for (std::size_t i = 0; i < mesh.triangle_count; ++i) {
        if (is_inactive(mesh, i)) continue;
        const Triangle t = mesh.triangle(i);
        const Vec3 n = cross(mesh.vertex(t[1]) - mesh.vertex(t[0]), mesh.vertex(t[2]) - mesh.vertex(t[0]));
        const double x = std::abs(static_cast<double>(n.x));
        const double y = std::abs(static_cast<double>(n.y));
        const double z = std::abs(static_cast<double>(n.z));
        const double norm = std::sqrt((x * x + y * y) + z * z);
        if (x > cosine * norm) area.x += norm;
        if (y > cosine * norm) area.y += norm;
        if (z > cosine * norm) area.z += norm;
        area.all += norm;
    }
    return area;
}

}  // namespace

Vec3 guess_up(const MeshView& mesh) {
    const FacingArea area = facing_area(mesh);
    const Aabb box = mesh_bounds(mesh);
    const bool mostly_floor = area.z > 1.5 * area.y;
    const bool is_built = area.x + area.y + area.z > 0.5 * area.all;
    const bool is_low = box.upper.z - box.lower.z < 0.7f * (box.upper.y - box.lower.y);
    return mostly_floor || (is_built && is_low) ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
}

Camera fit_camera(const MeshView& mesh, const Vec3& up, const ClosestHits& trace) {
    const Aabb box = mesh_bounds(mesh);
    if (!(box.lower.x <= box.upper.x)) return {{0, 0, 1}, {0, 0, 0}, up, 45.0f};
    const Aabb detail = box_of_detail(mesh);
    // Where all triangles are in one place there is no inside, and no room for a target ahead of an eye.
    const bool has_room = length(detail.upper - detail.lower) > 1e-5f * length(box.upper - box.lower);
    const bool inside = has_room && is_closed_around(detail, trace);
    return inside ? view_from_inside(grown(detail, 0.25f, box), up, trace)
                  : view_from_outside(grown(detail, 0.1f, box), up);
}

}  // namespace clbvh
