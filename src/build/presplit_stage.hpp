#pragma once

#include <cstdint>

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

    /// Splits a mesh that check_mesh has passed, as the build's part from fraction 0 to `end`. Keeps its memory.
    void run(const Mesh& mesh, double end);

    /// A line for each part, which stands for its box.
    [[nodiscard]] const Mesh& boxes() const noexcept { return parts_.mesh; }
    /// For each part the whole triangle, for builders that clip it; the boxes again for others.
    [[nodiscard]] const Mesh& triangles() const noexcept { return row_.clips_triangles ? triangles_ : parts_.mesh; }
    /// The triangle that each part is a part of.
    [[nodiscard]] std::span<const std::uint32_t> sources() const noexcept { return parts_.source; }

    /// Adds what the last run cost to a build's statistics.
    void book(BuildStats& stats) const;

private:
    const BuilderRow& row_;
    const BuildOptions& options_;
    host::PartBoxes parts_;
    Mesh triangles_;
    BuildStats stats_;
};

}  // namespace clbvh
