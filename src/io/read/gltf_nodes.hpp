#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/read/gltf_document.hpp"

namespace clbvh::io {

/// An affine map: rows of a 3 x 3 matrix, each with a part of the translation behind it.
struct Affine {
    std::array<std::array<double, 4>, 3> rows{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

    /// `inner` first, then `outer`.
    friend Affine operator*(const Affine& outer, const Affine& inner);
    [[nodiscard]] std::array<double, 3> operator()(const std::array<double, 3>& point) const;
    /// Whether it turns left into right.
    [[nodiscard]] bool mirrors() const;
};

/// The map of a translation, a rotation (quaternion x, y, z, w, of any length) and a scale, in this order from the
/// outside.
[[nodiscard]] Affine affine_of(const std::array<double, 3>& translation, const std::array<double, 4>& rotation,
                               const std::array<double, 3>& scale);
/// That of 16 numbers, column by column; the last row is left out.
[[nodiscard]] Affine affine_of_columns(const double* columns);

/// The nodes of a glTF file.
struct GltfNodes {
    std::vector<Affine> to_world;        ///< Of each node.
    std::vector<std::uint32_t> visited;  ///< Those of the file's scene, parents before children, in the file's order.
};

/// Finds the nodes of the scene that the file shows: `scene`, else the first one, else all nodes. Throws Error(io)
/// where a node has two parents, or is its own ancestor.
[[nodiscard]] GltfNodes place_nodes(const GltfDocument& document);

}  // namespace clbvh::io
