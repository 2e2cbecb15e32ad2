#pragma once

#include <clbvh/builder.hpp>
#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "measure/ray_cost.hpp"
#include "measure/sample.hpp"

namespace clbvh::tool {

/// The option or the size that differs between results, and its value in this one.
struct SweptValue {
    std::string what;
    std::uint64_t value = 0;
};

/// Of the options that a preset or an optimizer may have set, those that a builder ran with.
struct OptionsInUse {
    std::string optimizers;
    std::uint32_t optimize_passes = 0;
    std::uint32_t max_leaf_size = 0;
    float split_quota = 0.0f;
};

/// Result of one builder on one scene: in one run, or over the runs of a benchmark.
struct BuildResult {
    std::string scene;
    std::uint64_t triangles = 0;
    std::string builder;
    BuilderKind kind = BuilderKind::device;
    bool is_peer = false;                 ///< A builder of another library.
    Shape shape = Shape::automatic;       ///< automatic for a host builder.
    std::uint32_t radius = 0;             ///< 0 for a builder without a search radius.
    std::uint32_t threads = 0;            ///< Of a host builder; 0 elsewhere.
    std::optional<OptionsInUse> options;  ///< Absent for a peer.
    Sample build_ms;
    std::vector<StageStats> stages;  ///< Medians of the times.
    Sample launch_overhead_ms;  ///< Of a device builder: the build less the time in kernels and in stages on the host.
    std::uint32_t launches = 0;
    std::uint32_t iterations = 0;
    std::uint64_t peak_bytes = 0;  ///< The larger of the device's and the host's, input excluded.
    std::uint64_t inactive_primitives = 0;

    bool has_tree = false;  ///< Where a peer's tree cannot be read, the fields from here to the error say nothing.
    double sah = 0.0;       ///< NaN where the tree is not valid.
    double ray_cost = 0.0;  ///< SurfaceRayCost::cost; NaN where the tree is not valid.
    std::uint32_t depth = 0;
    std::uint64_t nodes = 0;
    std::uint64_t leaves = 0;
    std::uint64_t references = 0;  ///< Primitives of all leaves together.
    std::optional<bool> valid;     ///< Absent where the tree was not validated.
    std::string validation_error;

    /// From the making of the builder to its first tree: compilation, upload and first touch of memory included.
    std::optional<double> first_build_ms;
    std::optional<Sample> native_sort_ms;  ///< Sorting as many keys as there are triangles, in the same rounds.
    std::optional<Sample> copy_gb_per_s;   ///< Read and written by a copy on the device, in the same rounds.
    std::optional<SweptValue> sweep;
    std::optional<RayCost> rays;     ///< Of diffuse rays through the last tree, traced on the host.
    double binary_ns_per_ray = 0.0;  ///< Of the same through the tree's own nodes, two children at a time.

    [[nodiscard]] double mtris_per_s() const;
    [[nodiscard]] double peak_bytes_per_primitive() const;
    [[nodiscard]] double primitives_per_leaf() const;
};

/// True for a stage that ran on the host, before a device builder or behind it: "presplit", "download", "collapse".
[[nodiscard]] bool ran_on_host(const StageStats& stage);

/// Gigabytes (10^9) that the stage's kernels moved a second; NaN where it has no kernels or the queue does not profile.
[[nodiscard]] double gb_per_s(const StageStats& stage);

/// Fills the fields from `build_ms` to `inactive_primitives` with what `runs` cost, of which there is at least one.
void summarize_runs(BuildResult& result, std::span<const BuildStats> runs);

/// Fills the fields from `builder` to `options`.
void describe_builder(BuildResult& result, const Builder& builder);

/// Fills the number of triangles and the fields from `has_tree` to `validation_error`.
void describe_tree(BuildResult& result, const Bvh& bvh, const Mesh& mesh, bool validated);

/// Tells standard error about each tree that failed validation, and returns the exit code: a peer's tree is no failure.
[[nodiscard]] int report_invalid_trees(std::span<const BuildResult> results);

/// How many threads a host builder with these options runs on: no more than oneTBB allows.
[[nodiscard]] std::uint32_t host_threads(const BuildOptions& options);

[[nodiscard]] std::string threads_text(std::size_t count);  ///< "1 thread", "2 threads"

[[nodiscard]] std::string_view to_string(BuilderKind kind);  ///< "host", "device"

}  // namespace clbvh::tool
