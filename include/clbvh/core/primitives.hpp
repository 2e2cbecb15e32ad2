#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "clbvh/core/aabb.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Three indices of vertices.
using Triangle = std::array<std::uint32_t, 3>;

/// The type of one vertex index.
enum class IndexType : std::uint8_t { uint32, uint16 };

/// Largest magnitude of a coordinate. Beyond it half areas, or the distances of the builders, would overflow float32.
/// Products of an area and a cost may overflow a little before it: AAC then makes leaves of subtrees that cost less.
inline constexpr float kMaxCoordinate = 1e18f;

/// Most primitives of one build: node indices stay below 2^31.
inline constexpr std::uint64_t kMaxPrimitives = (std::uint64_t{1} << 30) - 1;

namespace view_detail {

template <typename T>
[[nodiscard]] const T* element(const void* first, std::uint64_t index, std::uint64_t stride) noexcept {
    return static_cast<const T*>(static_cast<const void*>(static_cast<const std::byte*>(first) + index * stride));
}

}  // namespace view_detail

/// Triangles in memory of the caller's. Nothing is owned, and strides are in bytes. Primitive i is triangle i.
///
///     struct Vertex { float position[3], normal[3], uv[2]; };
///     const clbvh::MeshView view{.vertices = vertices[0].position,
///                                .vertex_count = vertices.size(),
///                                .vertex_stride = sizeof(Vertex),
///                                .indices = indices.data(),
///                                .triangle_count = indices.size() / 3,
///                                .index_type = clbvh::IndexType::uint16};
struct MeshView {
    const float* vertices = nullptr;   ///< x y z of the first vertex, aligned to 4 bytes.
    std::uint64_t vertex_count = 0;    ///< Every index is below it.
    std::uint32_t vertex_stride = 12;  ///< From one vertex to the next: 12 or more, a multiple of 4.
    const void* indices = nullptr;     ///< Three for each triangle, aligned to their own size. Null: triangle i has
                                       ///< the vertices 3i, 3i + 1 and 3i + 2.
    std::uint64_t triangle_count = 0;  ///< At most kMaxPrimitives.
    IndexType index_type = IndexType::uint32;
    std::uint32_t index_stride = 0;  ///< From one triangle's first index to the next one's, no less than three indices
                                     ///< and a multiple of one; 0: just three.

    /// Vertex `index`, which is below vertex_count.
    [[nodiscard]] Vec3 vertex(std::uint64_t index) const noexcept {
        const auto* const v = view_detail::element<float>(vertices, index, vertex_stride);
        return {v[0], v[1], v[2]};
    }
    /// The indices of triangle `index`, which is below triangle_count.
    [[nodiscard]] Triangle triangle(std::uint64_t index) const noexcept {
        if (indices == nullptr) {
            const auto first = static_cast<std::uint32_t>(3 * index);
            return {first, first + 1, first + 2};
        }
        if (index_type == IndexType::uint32) {
            const auto* const i = view_detail::element<std::uint32_t>(indices, index, bytes_between_triangles());
            return {i[0], i[1], i[2]};
        }
        const auto* const i = view_detail::element<std::uint16_t>(indices, index, bytes_between_triangles());
        return {i[0], i[1], i[2]};
    }
    /// index_stride, or what its 0 stands for.
    [[nodiscard]] std::uint32_t bytes_between_triangles() const noexcept {
        if (index_stride != 0) return index_stride;
        return index_type == IndexType::uint32 ? 3 * sizeof(std::uint32_t) : 3 * sizeof(std::uint16_t);
    }
};

/// Boxes in memory of the caller's, for primitives that are not triangles. Nothing is owned. Primitive i is box i.
struct BoxView {
    const float* boxes = nullptr;  ///< Lower x y z and upper x y z of the first box, aligned to 4 bytes.
    std::uint64_t count = 0;       ///< At most kMaxPrimitives.
    std::uint32_t stride = 24;     ///< Bytes from one box to the next: 24 or more, a multiple of 4.

    BoxView() = default;
    BoxView(const float* first_box, std::uint64_t box_count, std::uint32_t bytes_between_boxes = 24) noexcept
        : boxes(first_box), count(box_count), stride(bytes_between_boxes) {}
    // NOLINTBEGIN(google-explicit-constructor): a view is what the range is
    BoxView(std::span<const Aabb> span) noexcept
        : boxes(reinterpret_cast<const float*>(span.data())), count(span.size()) {}
    /// Of a vector or an array.
    template <typename Range>
    requires std::convertible_to<const Range&, std::span<const Aabb>> BoxView(const Range& range)
    noexcept : BoxView(std::span<const Aabb>(range)) {}
    // NOLINTEND(google-explicit-constructor)

    /// Box `index`, which is below count.
    [[nodiscard]] Aabb box(std::uint64_t index) const noexcept {
        const auto* const b = view_detail::element<float>(boxes, index, stride);
        return {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
    }
};
static_assert(sizeof(Aabb) == 24);

/// The primitives that a tree is built over: a view of triangles or of boxes. A Mesh, or a vector or span of Aabb,
/// becomes one for free; it must then outlive the view.
using Primitives = std::variant<MeshView, BoxView>;

/// Triangles or boxes.
[[nodiscard]] CLBVH_API std::uint64_t count_of(const Primitives& primitives) noexcept;

/// The box of one triangle. Not meaningful for an inactive triangle.
[[nodiscard]] inline Aabb triangle_bounds(const MeshView& mesh, std::size_t triangle) {
    const auto [a, b, c] = mesh.triangle(triangle);
    const Vec3 first = mesh.vertex(a);
    return merge(merge(Aabb{first, first}, mesh.vertex(b)), mesh.vertex(c));
}

/// True where a coordinate of the triangle is NaN: such a primitive is left out of every tree and never hit.
[[nodiscard]] CLBVH_API bool is_inactive(const MeshView& mesh, std::size_t triangle);
/// The same for a box.
[[nodiscard]] CLBVH_API bool is_inactive(const BoxView& boxes, std::size_t box);

/// Checks the contract that every builder relies on, in parallel, and counts the inactive primitives.
/// Throws Error(invalid_input) where a pointer is null or not aligned, where a stride is too small or not a multiple of
/// what it has to be, or naming the first triangle with an index out of range or a coordinate that is infinite or
/// beyond kMaxCoordinate; and Error(unsupported) where there are more than kMaxPrimitives triangles.
[[nodiscard]] CLBVH_API std::uint64_t check_mesh(const MeshView& mesh);

/// The same for boxes: names the first with a lower corner above its upper one, or with a coordinate that is infinite
/// or beyond kMaxCoordinate.
[[nodiscard]] CLBVH_API std::uint64_t check_boxes(const BoxView& boxes);

/// check_mesh or check_boxes.
[[nodiscard]] CLBVH_API std::uint64_t check_primitives(const Primitives& primitives);

}  // namespace clbvh
