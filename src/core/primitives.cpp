#include "clbvh/core/primitives.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"
#include "core/own_group.hpp"
#include "core/primitive_access.hpp"
#include "core/primitive_limit.hpp"
#include "core/view_form.hpp"

namespace clbvh {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_input, what);
}

enum class State { active, inactive, offender };

/// Findings of a scan over a range of primitives.
struct Findings {
    std::uint64_t inactive = 0;
    std::size_t first_offender = kNone;
};

bool within_limits(float coordinate) {
    return std::abs(coordinate) <= kMaxCoordinate;
}

bool within_limits(const Vec3& v) {
    return within_limits(v.x) && within_limits(v.y) && within_limits(v.z);
}

template <typename Triangles>
State classify(const TriangleBoxes<Triangles>& access, std::size_t triangle) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
        if (access.triangles.index(triangle, corner) >= access.triangles.vertex_count) return State::offender;
    }
    if (access.is_inactive(triangle)) return State::inactive;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        if (!within_limits(access.corner(triangle, corner))) return State::offender;
    }
    return State::active;
}

bool is_upright(const Aabb& box) {
    return box.lower.x <= box.upper.x && box.lower.y <= box.upper.y && box.lower.z <= box.upper.z;
}

State classify(const PlainBoxes& access, std::size_t index) {
    if (access.is_inactive(index)) return State::inactive;
    const Aabb box = access.box(index);
    const bool is_legal = is_upright(box) && within_limits(box.lower) && within_limits(box.upper);
    return is_legal ? State::active : State::offender;
}

template <typename Access>
Findings scan(const Access& access) {
    constexpr std::size_t grain = 4096;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, access.count(), grain), Findings{},
        [&](const auto& range, Findings findings) {
            for (std::size_t i = range.begin(); i < range.end() && i < findings.first_offender; ++i) {
                const State state = classify(access, i);
                if (state == State::inactive) ++findings.inactive;
                if (state == State::offender) findings.first_offender = i;
            }
            return findings;
        },
        [](const Findings& a, const Findings& b) {
            return Findings{a.inactive + b.inactive, std::min(a.first_offender, b.first_offender)};
        });
}

/// True where `is_wrong(i)`, which is 0 or 1, is 1 for any i below `count`: without a branch that depends on data.
template <typename IsWrong>
bool any_of(std::size_t count, const IsWrong& is_wrong) {
    constexpr std::size_t grain = 16384;
    return tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, count, grain), false,
        [&](const auto& range, bool found) {
            unsigned wrong = found ? 1 : 0;
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                wrong |= is_wrong(i);
            return wrong != 0;
        },
        [](bool a, bool b) { return a || b; });
}

/// True where every index is in range, and every coordinate a number within the limit. False says nothing: a vertex
/// that no triangle has may be anything.
template <typename Triangles>
bool has_only_numbers(const Triangles& triangles) {
    const auto is_beyond = [](float coordinate) { return std::abs(coordinate) <= kMaxCoordinate ? 0u : 1u; };
    const bool wrong_vertex = any_of(triangles.vertex_count, [=](std::size_t i) {
        const float* const v = triangles.vertex(i);
        return is_beyond(v[0]) | is_beyond(v[1]) | is_beyond(v[2]);
    });
    if (wrong_vertex) return false;
    const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(triangles.vertex_count, ~0u));
    return !any_of(triangles.count, [=](std::size_t i) {
        const auto is_out = [&](std::size_t corner) {
            return static_cast<std::uint32_t>(triangles.index(i, corner)) < count ? 0u : 1u;
        };
        return is_out(0) | is_out(1) | is_out(2);
    });
}

/// There are enough vertices, and no index that could be out of range.
bool has_only_numbers(const LooseTriangles& triangles) {
    const auto is_beyond = [](float coordinate) { return std::abs(coordinate) <= kMaxCoordinate ? 0u : 1u; };
    return !any_of(3 * triangles.count, [=](std::size_t i) {
        const float* const v = triangles.vertex(i);
        return is_beyond(v[0]) | is_beyond(v[1]) | is_beyond(v[2]);
    });
}

[[noreturn]] void refuse_index(const MeshView& mesh, std::size_t triangle, std::uint32_t index) {
    refuse("triangle " + std::to_string(triangle) + ": vertex index " + std::to_string(index) +
           " is out of range (the mesh has " + std::to_string(mesh.vertex_count) + " vertices)");
}

/// Throws where `v` is beyond the limits. `whose` ends with what it is the coordinate of.
void check_coordinates(const Vec3& v, const std::string& primitive, const std::string& whose, const char* way_out) {
    for (const auto& [axis, value] : {std::pair{'x', v.x}, std::pair{'y', v.y}, std::pair{'z', v.z}}) {
        if (within_limits(value)) continue;
        std::ostringstream message;
        message << primitive << ": coordinate " << axis << " of " << whose << " is " << value
                << "; coordinates must be finite and at most " << kMaxCoordinate << " in magnitude: " << way_out;
        refuse(message.str());
    }
}

/// Throws: the triangle has an index or a coordinate that is not as it should be.
void refuse_triangle(const MeshView& mesh, std::size_t triangle) {
    const Triangle indices = mesh.triangle(triangle);
    for (const std::uint32_t index : indices) {
        if (index >= mesh.vertex_count) refuse_index(mesh, triangle, index);
    }
    for (const std::uint32_t index : indices) {
        check_coordinates(mesh.vertex(index), "triangle " + std::to_string(triangle), "vertex " + std::to_string(index),
                          "repair or scale the mesh, or set the coordinate to NaN to leave the triangle out");
    }
}

/// Throws: the box is not as it should be.
void refuse_box(const BoxView& boxes, std::size_t index) {
    const Aabb box = boxes.box(index);
    const std::string name = "box " + std::to_string(index);
    constexpr const char* way_out = "repair or scale the boxes, or set the coordinate to NaN to leave the box out";
    check_coordinates(box.lower, name, "its lower corner", way_out);
    check_coordinates(box.upper, name, "its upper corner", way_out);
    refuse(name + ": its lower corner is above its upper one: repair it, or set a coordinate to NaN to leave it out");
}

}  // namespace

std::uint64_t count_of(const Primitives& primitives) noexcept {
    const auto* const boxes = std::get_if<BoxView>(&primitives);
    return boxes != nullptr ? boxes->count : std::get<MeshView>(primitives).triangle_count;
}

bool is_inactive(const MeshView& mesh, std::size_t triangle) {
    const auto [a, b, c] = mesh.triangle(triangle);
    return has_nan(mesh.vertex(a)) || has_nan(mesh.vertex(b)) || has_nan(mesh.vertex(c));
}

bool is_inactive(const BoxView& boxes, std::size_t box) {
    return PlainBoxes{boxes}.is_inactive(box);
}

void check_primitive_count(std::uint64_t count, std::string_view what) {
    if (count <= kMaxPrimitives) return;
    throw Error(ErrorCode::unsupported, std::to_string(count) + " " + std::string(what) +
                                            " are more than one build can take (" + std::to_string(kMaxPrimitives) +
                                            "): split them up");
}

std::uint64_t check_mesh(const MeshView& mesh) {
    check_primitive_count(mesh.triangle_count, "triangles");
    check_form(mesh);
    const Findings findings = with_triangles(mesh, [](const auto& triangles) {
        return in_own_group([&] { return has_only_numbers(triangles) ? Findings{} : scan(TriangleBoxes{triangles}); });
    });
    if (findings.first_offender != kNone) refuse_triangle(mesh, findings.first_offender);
    return findings.inactive;
}

std::uint64_t check_boxes(const BoxView& boxes) {
    check_primitive_count(boxes.count, "boxes");
    check_form(boxes);
    const Findings findings = in_own_group([&] { return scan(PlainBoxes{boxes}); });
    if (findings.first_offender != kNone) refuse_box(boxes, findings.first_offender);
    return findings.inactive;
}

std::uint64_t check_primitives(const Primitives& primitives) {
    const auto* const boxes = std::get_if<BoxView>(&primitives);
    return boxes != nullptr ? check_boxes(*boxes) : check_mesh(std::get<MeshView>(primitives));
}

}  // namespace clbvh
