#pragma once

#include <cstddef>
#include <cstdint>

#include "clbvh/core/primitives.hpp"
#include "core/primitive_access.hpp"
#include "core/simd/box4.hpp"
#include "core/simd/prefetch.hpp"

// How a refit reads primitives: it merges one into a box, and fetches what it will read. What is NaN changes nothing.
namespace clbvh {

/// `Triangles` is one of primitive_access.hpp.
template <typename Triangles>
struct MergeTriangles {
    Triangles triangles;

    void merge_into(Box4& box, std::uint32_t triangle) const noexcept {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Float4 point = vertex(triangles.index(triangle, corner));
            box = {min(point, box.lower), max(point, box.upper)};
        }
    }
    void prefetch_of(std::uint32_t triangle) const noexcept { prefetch(triangles.indices_of(triangle)); }
    /// Reads what prefetch_of asks for.
    void prefetch_vertices_of(std::uint32_t triangle) const noexcept {
        for (std::size_t corner = 0; corner < 3; ++corner)
            prefetch(triangles.vertex(triangles.index(triangle, corner)));
    }

    /// A vertex takes three words. The fourth that is read belongs to the next one.
    [[nodiscard]] Float4 vertex(std::uint64_t index) const noexcept {
        const float* const v = triangles.vertex(index);
        return index + 1 < triangles.vertex_count ? Float4::load(v) : Float4::of(v[0], v[1], v[2]);
    }
};
template <typename Triangles>
MergeTriangles(Triangles) -> MergeTriangles<Triangles>;

struct MergeBoxes {
    BoxView boxes;

    void merge_into(Box4& box, std::uint32_t index) const noexcept {
        const float* const corners = corners_of(index);
        box = {min(Float4::load(corners), box.lower), max(Float4::of(corners[3], corners[4], corners[5]), box.upper)};
    }
    void prefetch_of(std::uint32_t index) const noexcept { prefetch(corners_of(index)); }
    void prefetch_vertices_of(std::uint32_t /*index*/) const noexcept {}

private:
    [[nodiscard]] const float* corners_of(std::uint32_t index) const noexcept {
        return view_detail::element<float>(boxes.boxes, index, boxes.stride);
    }
};

/// Calls `work(reader)` with the way to merge the primitives.
template <typename Work>
decltype(auto) with_merging(const Primitives& primitives, const Work& work) {
    if (const auto* const boxes = std::get_if<BoxView>(&primitives)) return work(MergeBoxes{*boxes});
    return with_triangles(std::get<MeshView>(primitives),
                          [&](const auto& triangles) -> decltype(auto) { return work(MergeTriangles{triangles}); });
}

}  // namespace clbvh
