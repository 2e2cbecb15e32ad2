#include "clbvh/core/mesh.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/primitive_limit.hpp"

namespace clbvh {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

enum class TriangleState { active, inactive, offender };

/// What a scan over a range of triangles found.
struct Findings {
    std::uint64_t inactive = 0;
    std::size_t first_offender = kNone;
};

bool has_nan(const Vec3& v) {
    return std::isnan(v.x) || std::isnan(v.y) || std::isnan(v.z);
}

bool within_limits(float coordinate) {
    return std::abs(coordinate) <= kMaxCoordinate;
}

bool within_limits(const Vec3& v) {
    return within_limits(v.x) && within_limits(v.y) && within_limits(v.z);
}

TriangleState classify(const Mesh& mesh, std::size_t triangle) {
    const Triangle& indices = mesh.triangles[triangle];
    const bool in_range = std::max({indices[0], indices[1], indices[2]}) < mesh.vertices.size();
    if (!in_range) return TriangleState::offender;
    if (is_inactive(mesh, triangle)) return TriangleState::inactive;
    const bool finite = std::all_of(indices.begin(), indices.end(),
                                    [&](std::uint32_t index) { return within_limits(mesh.vertices[index]); });
    return finite ? TriangleState::active : TriangleState::offender;
}

Findings scan(const Mesh& mesh, const tbb::blocked_range<std::size_t>& range, Findings findings) {
    for (std::size_t i = range.begin(); i < range.end() && i < findings.first_offender; ++i) {
        const TriangleState state = classify(mesh, i);
        if (state == TriangleState::inactive) ++findings.inactive;
        if (state == TriangleState::offender) findings.first_offender = i;
    }
    return findings;
}

/// True where every index is in range, and every coordinate a number within the limit: two scans without a branch that
/// depends on data. False says nothing: a vertex that no triangle has may be anything.
bool has_only_numbers(const Mesh& mesh) {
    constexpr std::size_t grain = 16384;
    const auto any_of = [](std::size_t count, const auto& is_wrong) {
        return tbb::parallel_reduce(
            tbb::blocked_range<std::size_t>(0, count, grain), false,
            [&](const auto& range, bool found) {
                unsigned wrong = found ? 1 : 0;
                for (std::size_t i = range.begin(); i < range.end(); ++i)
                    wrong |= is_wrong(i);
                return wrong != 0;
            },
            [](bool a, bool b) { return a || b; });
    };
    const Vec3* const vertices = mesh.vertices.data();
    const auto is_beyond = [](float coordinate) { return std::abs(coordinate) <= kMaxCoordinate ? 0u : 1u; };
    const bool wrong_vertex = any_of(mesh.vertices.size(), [=](std::size_t i) {
        return is_beyond(vertices[i].x) | is_beyond(vertices[i].y) | is_beyond(vertices[i].z);
    });
    const Triangle* const triangles = mesh.triangles.data();
    const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(mesh.vertices.size(), ~0u));
    return !wrong_vertex && !any_of(mesh.triangles.size(), [=](std::size_t i) {
        const Triangle& t = triangles[i];
        return (t[0] < count ? 0u : 1u) | (t[1] < count ? 0u : 1u) | (t[2] < count ? 0u : 1u);
    });
}

[[noreturn]] void throw_index_error(const Mesh& mesh, std::size_t triangle, std::uint32_t index) {
    throw Error(ErrorCode::invalid_input, "triangle " + std::to_string(triangle) + ": vertex index " +
                                              std::to_string(index) + " is out of range (the mesh has " +
                                              std::to_string(mesh.vertices.size()) + " vertices)");
}

[[noreturn]] void throw_coordinate_error(std::size_t triangle, std::uint32_t vertex, char axis, float value) {
    std::ostringstream message;
    message << "triangle " << triangle << ": coordinate " << axis << " of vertex " << vertex << " is " << value
            << "; coordinates must be finite and at most " << kMaxCoordinate
            << " in magnitude: repair or scale the mesh, or set the coordinate to NaN to leave the triangle out";
    throw Error(ErrorCode::invalid_input, message.str());
}

[[noreturn]] void throw_offence(const Mesh& mesh, std::size_t triangle) {
    const Triangle& indices = mesh.triangles[triangle];
    for (const std::uint32_t index : indices) {
        if (index >= mesh.vertices.size()) throw_index_error(mesh, triangle, index);
    }
    const auto vertex = *std::find_if(indices.begin(), indices.end(),
                                      [&](std::uint32_t index) { return !within_limits(mesh.vertices[index]); });
    const Vec3& v = mesh.vertices[vertex];
    if (!within_limits(v.x)) throw_coordinate_error(triangle, vertex, 'x', v.x);
    if (!within_limits(v.y)) throw_coordinate_error(triangle, vertex, 'y', v.y);
    throw_coordinate_error(triangle, vertex, 'z', v.z);
}

}  // namespace

bool is_inactive(const Mesh& mesh, std::size_t triangle) {
    const Triangle& t = mesh.triangles[triangle];
    return has_nan(mesh.vertices[t[0]]) || has_nan(mesh.vertices[t[1]]) || has_nan(mesh.vertices[t[2]]);
}

void check_primitive_count(std::uint64_t count) {
    if (count <= kMaxPrimitives) return;
    throw Error(ErrorCode::unsupported, std::to_string(count) + " triangles are more than one build can take (" +
                                            std::to_string(kMaxPrimitives) + "): split the mesh");
}

std::uint64_t check_mesh(const Mesh& mesh) {
    check_primitive_count(mesh.triangles.size());
    if (has_only_numbers(mesh)) return 0;
    constexpr std::size_t grain = 4096;
    const Findings findings = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, mesh.triangles.size(), grain), Findings{},
        [&](const auto& range, const Findings& before) { return scan(mesh, range, before); },
        [](const Findings& a, const Findings& b) {
            return Findings{a.inactive + b.inactive, std::min(a.first_offender, b.first_offender)};
        });
    if (findings.first_offender != kNone) throw_offence(mesh, findings.first_offender);
    return findings.inactive;
}

}  // namespace clbvh
