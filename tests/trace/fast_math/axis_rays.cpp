// Compiled several times, each with other flags that let compilers forget about infinities, NaNs or the sign of zero:
// AXIS_RAYS is the name of the function.
#include "trace/fast_math/axis_rays.hpp"

#include <bit>

#include "clbvh/core/mesh.hpp"
#include "clbvh/host/sweep_sah.hpp"
#include "clbvh/layout/traverse.hpp"
#include "clbvh/trace/traverse.hpp"

namespace clbvh::test {
namespace {

// All coordinates are multiples of a half, and counted in halves: integers, which no flag makes less exact.
constexpr int kPerAxis = 4;
constexpr int kPitch = 4;  // from one box to the next
constexpr int kEdge = 2;   // of a box

using Corner = std::array<int, 3>;

float coordinate(int halves) {
    return 0.5f * static_cast<float>(halves);
}

std::vector<Corner> lower_corners() {
    std::vector<Corner> corners;
    for (int i = 0; i < kPerAxis * kPerAxis * kPerAxis; ++i) {
        corners.push_back(
            {i % kPerAxis * kPitch, i / kPerAxis % kPerAxis * kPitch, i / (kPerAxis * kPerAxis) * kPitch});
    }
    return corners;
}

Aabb box_at(const Corner& lower) {
    return {{coordinate(lower[0]), coordinate(lower[1]), coordinate(lower[2])},
            {coordinate(lower[0] + kEdge), coordinate(lower[1] + kEdge), coordinate(lower[2] + kEdge)}};
}

bool lies_beside(int place, int lower) {
    return place >= lower && place <= lower + kEdge;
}

/// A ray along an axis, through (u, v) on the two others, whose directions are zeros of either sign.
struct AxisRay {
    unsigned axis;
    bool is_forward;
    int u, v;
    unsigned zero_signs;

    [[nodiscard]] bool is_within(const Corner& lower) const {
        return lies_beside(u, lower[(axis + 1) % 3]) && lies_beside(v, lower[(axis + 2) % 3]);
    }
    [[nodiscard]] Ray ray() const {
        std::array<float, 3> origin{}, direction{};
        origin[axis] = is_forward ? -5.0f : 15.0f;
        origin[(axis + 1) % 3] = coordinate(u);
        origin[(axis + 2) % 3] = coordinate(v);
        direction[axis] = is_forward ? 1.0f : -1.0f;
        direction[(axis + 1) % 3] = std::bit_cast<float>((zero_signs & 1u) << 31);
        direction[(axis + 2) % 3] = std::bit_cast<float>((zero_signs >> 1) << 31);
        Ray ray;
        ray.origin = {origin[0], origin[1], origin[2]};
        ray.direction = {direction[0], direction[1], direction[2]};
        return ray;
    }
};

/// A tree over boxes, and a layout over triangles that have these boxes.
struct Trees {
    Bvh binary;
    Wide8 wide;

    explicit Trees(const std::vector<Aabb>& boxes) : binary(build_sweep_sah(boxes)) {
        Mesh mesh;
        for (const Aabb& box : boxes) {
            const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
            mesh.vertices.insert(mesh.vertices.end(), {box.lower, box.upper, {box.lower.x, box.upper.y, box.lower.z}});
            mesh.triangles.push_back({first, first + 1, first + 2});
        }
        make_layout(binary, mesh, wide);
    }
};

bool is_right(const std::vector<Corner>& corners, const Trees& trees, const AxisRay& axis_ray) {
    std::vector<int> visits(corners.size(), 0), wide_visits(corners.size(), 0);
    traverse(trees.binary.nodes, axis_ray.ray(), [&](std::uint32_t first, std::uint32_t count, float&) {
        for (std::uint32_t i = first; i < first + count; ++i)
            ++visits[trees.binary.primitive_ids[i]];
        return true;
    });
    traverse(trees.wide, axis_ray.ray(), [&](std::span<const TriangleBlock> blocks, float&) {
        for (const TriangleBlock& block : blocks) {
            for (const std::uint32_t primitive : block.primitives) {
                if (primitive != kNoPrimitive) ++wide_visits[primitive];
            }
        }
        return true;
    });
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (axis_ray.is_within(corners[i]) && (visits[i] != 1 || wide_visits[i] != 1)) return false;
    }
    return true;
}

/// Rays that are not to be traced, each of which would visit the box if it were.
unsigned count_traced_among_invalid() {
    const float infinity = std::bit_cast<float>(0x7F800000u);
    const float nan = std::bit_cast<float>(0x7FC00000u);
    const std::vector<Node> box{{{-1.0f, -1.0f, -1.0f}, 0, {1.0f, 1.0f, 1.0f}, 1}};
    const Ray good{{0.0f, 0.0f, 0.0f}, 0.0f, {1.0f, 0.0f, 0.0f}, infinity};
    std::vector<Ray> invalid(6, good);
    invalid[0].origin.y = nan;
    invalid[1].origin.x = infinity;
    invalid[2].direction.z = infinity;
    invalid[3].direction.x = nan;
    invalid[4].direction.x = 0.0f;
    invalid[5].t_max = nan;
    unsigned visited = 0;
    const auto visit = [&](std::uint32_t, std::uint32_t, float&) { return ++visited > 0; };
    for (const Ray& ray : invalid)
        traverse(box, ray, visit);
    const unsigned wrong = visited;
    traverse(box, good, visit);
    return visited == wrong + 1 ? wrong : wrong + 1;
}

}  // namespace

AxisRaysFound AXIS_RAYS() {
    const std::vector<Corner> corners = lower_corners();
    std::vector<Aabb> boxes;
    Aabb all;
    for (const Corner& corner : corners) {
        boxes.push_back(box_at(corner));
        all = merge(all, boxes.back());
    }
    const Trees trees(boxes);
    AxisRaysFound found;
    found.bounds = all;
    found.invalid_traced = count_traced_among_invalid();
    for (unsigned axis = 0; axis < 3; ++axis) {
        for (const bool is_forward : {true, false}) {
            for (unsigned zero_signs = 0; zero_signs < 4; ++zero_signs) {
                for (const int u : {-1, 0, 1, 2, 3, 4, 13, 14, 18}) {
                    for (const int v : {-1, 0, 1, 2, 3, 4, 13, 14, 18}) {
                        ++found.rays;
                        if (!is_right(corners, trees, {axis, is_forward, u, v, zero_signs})) ++found.wrong;
                    }
                }
            }
        }
    }
    return found;
}

}  // namespace clbvh::test
