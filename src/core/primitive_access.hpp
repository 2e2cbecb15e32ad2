#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <variant>

#include "clbvh/core/primitives.hpp"

// How primitives lie in memory, known when a loop over them is compiled. Loops that are hot are templates over one of
// these, and with_access() picks the instance.
namespace clbvh {

/// Packed vertices and packed uint indices: a Mesh, and whatever lies like one.
struct PackedTriangles {
    const float* vertices;
    const std::uint32_t* indices;
    std::uint64_t vertex_count;
    std::uint64_t count;

    [[nodiscard]] std::uint64_t index(std::size_t triangle, std::size_t corner) const noexcept {
        return indices[3 * triangle + corner];
    }
    /// The three floats of a vertex.
    [[nodiscard]] const float* vertex(std::uint64_t index) const noexcept { return vertices + 3 * index; }
    /// The address to fetch before triangle `triangle` is read.
    [[nodiscard]] const void* indices_of(std::size_t triangle) const noexcept { return indices + 3 * triangle; }
};

/// Any strides, and indices of one type.
template <typename Index>
struct IndexedTriangles {
    const float* vertices;
    const void* indices;
    std::uint64_t vertex_stride;
    std::uint64_t index_stride;
    std::uint64_t vertex_count;
    std::uint64_t count;

    [[nodiscard]] std::uint64_t index(std::size_t triangle, std::size_t corner) const noexcept {
        return view_detail::element<Index>(indices, triangle, index_stride)[corner];
    }
    [[nodiscard]] const float* vertex(std::uint64_t index) const noexcept {
        return view_detail::element<float>(vertices, index, vertex_stride);
    }
    [[nodiscard]] const void* indices_of(std::size_t triangle) const noexcept {
        return view_detail::element<Index>(indices, triangle, index_stride);
    }
};

/// Vertices three by three.
struct LooseTriangles {
    const float* vertices;
    std::uint64_t vertex_stride;
    std::uint64_t vertex_count;
    std::uint64_t count;

    [[nodiscard]] static std::uint64_t index(std::size_t triangle, std::size_t corner) noexcept {
        return 3 * triangle + corner;
    }
    [[nodiscard]] const float* vertex(std::uint64_t index) const noexcept {
        return view_detail::element<float>(vertices, index, vertex_stride);
    }
    [[nodiscard]] const void* indices_of(std::size_t triangle) const noexcept { return vertex(3 * triangle); }
};

[[nodiscard]] inline bool has_nan(const Vec3& v) noexcept {
    return std::isnan(v.x) || std::isnan(v.y) || std::isnan(v.z);
}

/// Boxes of triangles.
template <typename Triangles>
struct TriangleBoxes {
    Triangles triangles;

    [[nodiscard]] std::uint64_t count() const noexcept { return triangles.count; }
    /// Where it lies: with a copy, the loop that writes references takes half as long again (GCC 12).
    [[nodiscard]] const Vec3& corner(std::size_t triangle, std::size_t corner) const noexcept {
        return *view_detail::element<Vec3>(triangles.vertex(triangles.index(triangle, corner)), 0, 0);
    }
    [[nodiscard]] Aabb box(std::size_t triangle) const noexcept {
        const Vec3& first = corner(triangle, 0);
        return merge(merge(Aabb{first, first}, corner(triangle, 1)), corner(triangle, 2));
    }
    [[nodiscard]] bool is_inactive(std::size_t triangle) const noexcept {
        return has_nan(corner(triangle, 0)) || has_nan(corner(triangle, 1)) || has_nan(corner(triangle, 2));
    }
};
// Clang before 17 deduces nothing for aggregates.
template <typename Triangles>
TriangleBoxes(Triangles) -> TriangleBoxes<Triangles>;

/// Boxes as they are.
struct PlainBoxes {
    BoxView boxes;

    [[nodiscard]] std::uint64_t count() const noexcept { return boxes.count; }
    [[nodiscard]] Aabb box(std::size_t index) const noexcept { return boxes.box(index); }
    [[nodiscard]] bool is_inactive(std::size_t index) const noexcept {
        const Aabb box = boxes.box(index);
        return has_nan(box.lower) || has_nan(box.upper);
    }
};

/// Calls `work(triangles)` with the way in which the mesh lies in memory.
template <typename Work>
decltype(auto) with_triangles(const MeshView& mesh, const Work& work) {
    const auto stride = std::uint64_t{mesh.bytes_between_triangles()};
    if (mesh.indices == nullptr)
        return work(LooseTriangles{mesh.vertices, mesh.vertex_stride, mesh.vertex_count, mesh.triangle_count});
    if (mesh.index_type == IndexType::uint16) {
        return work(IndexedTriangles<std::uint16_t>{mesh.vertices, mesh.indices, mesh.vertex_stride, stride,
                                                    mesh.vertex_count, mesh.triangle_count});
    }
    if (mesh.vertex_stride == 3 * sizeof(float) && stride == 3 * sizeof(std::uint32_t)) {
        return work(PackedTriangles{mesh.vertices, static_cast<const std::uint32_t*>(mesh.indices), mesh.vertex_count,
                                    mesh.triangle_count});
    }
    return work(IndexedTriangles<std::uint32_t>{mesh.vertices, mesh.indices, mesh.vertex_stride, stride,
                                                mesh.vertex_count, mesh.triangle_count});
}

/// Calls `work(boxes)` with the way to the primitives' boxes: TriangleBoxes or PlainBoxes.
template <typename Work>
decltype(auto) with_boxes(const Primitives& primitives, const Work& work) {
    if (const auto* const boxes = std::get_if<BoxView>(&primitives)) return work(PlainBoxes{*boxes});
    return with_triangles(std::get<MeshView>(primitives), [&](const auto& triangles) -> decltype(auto) {
        return work(TriangleBoxes<std::remove_cvref_t<decltype(triangles)>>{triangles});
    });
}

/// The box of one primitive, where no loop is hot. Not meaningful where it is inactive.
[[nodiscard]] inline Aabb primitive_bounds(const Primitives& primitives, std::size_t index) {
    const auto* const boxes = std::get_if<BoxView>(&primitives);
    return boxes != nullptr ? boxes->box(index) : triangle_bounds(std::get<MeshView>(primitives), index);
}

[[nodiscard]] inline bool is_inactive_primitive(const Primitives& primitives, std::size_t index) {
    const auto* const boxes = std::get_if<BoxView>(&primitives);
    return boxes != nullptr ? is_inactive(*boxes, index) : is_inactive(std::get<MeshView>(primitives), index);
}

/// "the mesh has 5 triangles", "there are 5 boxes".
[[nodiscard]] inline std::string count_in_words(const Primitives& primitives) {
    const std::string count = std::to_string(count_of(primitives));
    const bool is_mesh = std::holds_alternative<MeshView>(primitives);
    return is_mesh ? "the mesh has " + count + " triangles" : "there are " + count + " boxes";
}

}  // namespace clbvh
