#pragma once

#include <clbvh/builder.hpp>
#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sample.hpp"

namespace clbvh::tool {

/// What one builder did on one scene: in one run, or over the runs of a benchmark.
struct BuildResult {
    std::string scene;
    std::uint64_t triangles = 0;
    std::string builder;
    Shape shape = Shape::automatic;
    std::uint32_t radius = 0;  ///< 0 for a builder without a search radius.
    Sample build_ms;
    std::vector<StageStats> stages;  ///< Medians of the times.
    std::uint32_t launches = 0;
    std::uint32_t iterations = 0;
    std::uint64_t peak_device_bytes = 0;
    std::uint64_t inactive_primitives = 0;

    double sah = 0.0;  ///< NaN where the tree is not valid.
    std::uint32_t depth = 0;
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::optional<bool> valid;  ///< Absent where the tree was not validated.
    std::string validation_error;

    /// From the making of the builder to its first tree: compilation, upload and first touch of memory included.
    std::optional<double> first_build_ms;
    std::optional<Sample> native_sort_ms;  ///< Sorting as many keys as there are triangles, in the same rounds.

    [[nodiscard]] double mtris_per_s() const;
    [[nodiscard]] double peak_bytes_per_primitive() const;
};

/// Describes `runs`, of which there is at least one, all of the builder's current mesh.
[[nodiscard]] BuildResult summarize_runs(const Builder& builder, std::string_view scene, const Mesh& mesh,
                                         std::span<const BuildStats> runs);

/// Fills the fields from `sah` to `validation_error`.
void describe_tree(BuildResult& result, const Bvh& bvh, const Mesh& mesh, bool validated);

/// Tells standard error about each tree that failed validation, and returns the exit code.
[[nodiscard]] int report_invalid_trees(std::span<const BuildResult> results);

}  // namespace clbvh::tool
