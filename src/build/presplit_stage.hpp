#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "catalog/builder_rows.hpp"
#include "clbvh/core/build_stats.hpp"
#include "clbvh/options.hpp"
#include "host/split/presplit.hpp"

namespace clbvh {

/// The stage before any builder: triangles with bad edges, or with boxes that have most to lose, are split, and their
/// parts built over.
class PresplitStage {
public:
    PresplitStage(const BuilderRow& row, const BuildOptions& options) : row_(row), options_(options) {}

    /// Splits a mesh that check_mesh has passed, and that stays until the parts are built over, as the build's part
    /// from fraction 0 to `end`. Keeps its memory.
    void run(const MeshView& mesh, double end);

    /// For each part its box.
    [[nodiscard]] std::span<const Aabb> boxes() const noexcept { return parts_.boxes; }
    /// For each part the whole triangle, for builders that cut it; its vertices are those of the mesh.
    [[nodiscard]] const std::optional<MeshView>& triangles() const noexcept { return triangles_; }
    /// The triangle that each part is a part of.
    [[nodiscard]] std::span<const std::uint32_t> sources() const noexcept { return parts_.source; }

    /// Adds what the last run cost to a build's statistics.
    void book(BuildStats& stats) const;

private:
    void name_triangles(const MeshView& mesh);

    const BuilderRow& row_;
    const BuildOptions& options_;
    host::PartBoxes parts_;
    std::vector<Triangle> indices_;  // of `triangles_`
    std::optional<MeshView> triangles_;
    BuildStats stats_;
};

}  // namespace clbvh
