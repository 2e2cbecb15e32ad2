#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "clbvh/core/build_stats.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// How a kernel lays its work out. Both shapes give the same tree.
enum class Shape : std::uint8_t {
    automatic,  ///< lane on CPU devices that pass the self-test, group elsewhere.
    group,      ///< A work group shares a chunk in local memory with barriers, as the papers write it.
    lane,       ///< Work-group size 1: one work item owns a chunk and loops over it.
};

/// Which spatial code orders the primitives.
enum class MortonCode : std::uint8_t {
    xyz,       ///< 3D, 21 bits an axis.
    extended,  ///< 4D extended (Vinkler, Bittner, Havran 2017): axes split longest first, with bits for the primitive's
               ///< size.
};

/// How the fused kernels of PLOC++ pack a distance and its neighbour into one integer (section 4.3).
enum class NeighbourEncoding : std::uint8_t {
    automatic,  ///< bits32.
    bits32,     ///< Distance with its lowest mantissa bits replaced by the relative offset.
    bits64,     ///< Exact distance above the offset; the group shape needs 64-bit local atomics, or the scan search.
};

/// How the group shape finds neighbours in local memory.
enum class NeighbourSearch : std::uint8_t {
    automatic,  ///< symmetric on GPUs, scan on CPU devices, where local atomics cost more than the distances they save.
    symmetric,  ///< Each pair measured once, both sides updated by a local atomic minimum (PLOC++ algorithm 1).
    scan,       ///< Each side measures its own 2 R pairs; no atomics.
};

/// Presets of H-PLOC: what its options become where they are left to it.
enum class HplocQuality : std::uint8_t {
    balanced,  ///< cluster_limit 16, small_range 1, merge_pairs on: trees as good as PLOC's.
    fast,  ///< cluster_limit 16, small_range 256 with small_limit 8, merge_pairs on, code_bits 33: faster in the lane
           ///< shape, slower in the group shape; trees a little worse.
};

/// Which clusters of a node H-PLOC compares.
enum class HplocSearch : std::uint8_t {
    automatic,  ///< all_pairs.
    all_pairs,  ///< Each with every other.
    window,     ///< Each with search_radius to each side, at most 31, as the paper has it.
};

/// Whether a pair of neighbouring primitives that share a node of the Morton tree merges at once.
enum class PairMerging : std::uint8_t {
    automatic,  ///< As the preset says.
    on,
    off,
};

/// Where the optimisers of a build run. On a device they can be cancelled only before they begin.
enum class OptimizeOn : std::uint8_t {
    host,    ///< All optimisers, on the tree of any builder.
    device,  ///< On the device that built the tree, before it is downloaded; those with OptimizerInfo::on_device.
};

/// Options of all builders; each reads those that concern it. A zero size means: chosen for the builder or the device.
struct BuildOptions {
    float inner_cost = 1.2f;          ///< Cost of visiting an inner node, above 0: SAH builders, flattening.
    float primitive_cost = 1.0f;      ///< Cost of testing one primitive, above 0: SAH builders, flattening.
    std::uint32_t max_leaf_size = 0;  ///< Most primitives of a leaf, 1 to 64. Where given, the finished tree's leaves
                                      ///< are merged as far as that lowers its SAH cost; 0: as the builder leaves it.
    std::uint32_t bin_count = 16;     ///< binned-sah, sbvh: bins an axis, 2 to 64.
    bool bin_longest_axis_only = false;  ///< binned-sah: bins along the longest axis of the centroids' bounds only.
    float split_alpha = 1e-5f;           ///< sbvh: least overlap of children, relative to the scene's half area, that
                                         ///< makes it try a spatial split, 0 to 1.
    float reference_budget = 2.0f;       ///< sbvh: most references, as a multiple of the primitives, 1 to 8.
    std::uint32_t presplit_level = 0;    ///< Before any builder, split triangles that have an edge whose box is larger
                                         ///< than the scene's volume / 2^level, 1 to 40; the paper's is 14. 0: do not.
    float split_quota = 0.0f;  ///< Before any builder, split the triangles whose boxes have most to lose, so that
                               ///< there are at most so many splits a triangle, above 0 to 4; 0.3 is the paper's
                               ///< (see docs/presplit.md). 0: do not. Not with presplit_level.
    std::string optimizers;    ///< After any builder, before leaves are merged: ids of optimizers() with commas
                               ///< between them, "reinsert" say. Empty: none.
    std::uint32_t optimize_passes = 0;  ///< Most passes of each of them; on a device never more than 1000. 0: as many
                                        ///< as it finds worth while.
    OptimizeOn optimize_on = OptimizeOn::host;  ///< Where they run; see OptimizeOn.
    std::uint32_t thread_count = 0;  ///< Threads of the host's work, 1 to 1024; 0: all. The tree is always the same.

    std::uint32_t search_radius = 16;  ///< R of PLOC and PLOC++, and of hploc with HplocSearch::window: neighbours
                                       ///< searched to each side, 1 to 32.
    Shape shape = Shape::automatic;    ///< See Shape.
    Shape sort_shape =
        Shape::automatic;  ///< Shape of the sort alone; automatic: lane on CPU devices that pass the self-test.
    MortonCode morton_code = MortonCode::xyz;  ///< See MortonCode.
    std::uint32_t code_bits = 0;  ///< Leading bits of the 63-bit spatial code that order primitives, equal ones by id.
                                  ///< 33 or 44 (as many of them as leave room for the id): code and id are sorted as
                                  ///< one 64-bit key. 63: as PLOC++ has it, 32-bit keys with a value, twice. 0: 44, or
                                  ///< 33 for hploc with HplocQuality::fast.
    NeighbourEncoding neighbour_encoding = NeighbourEncoding::automatic;  ///< See NeighbourEncoding.
    NeighbourSearch neighbour_search = NeighbourSearch::automatic;        ///< See NeighbourSearch.
    std::uint32_t single_group_threshold = 0;  ///< plocpp: clusters below which one work group finishes the tree, 2 to
                                               ///< 2^20; 0: chosen.
    std::uint32_t chunk_size = 0;       ///< Clusters per chunk of the lane shape, 64 to 4096 in steps of 64; 0: chosen.
    std::uint32_t work_group_size = 0;  ///< Work items of the group shape, a power of two, 32 to 1024; 0: chosen.
    std::uint32_t range_count = 0;      ///< plocpp-two-level: least number of Morton ranges, 1 to 512; 0: chosen.
    HplocQuality hploc_quality = HplocQuality::balanced;  ///< hploc: see HplocQuality.
    HplocSearch hploc_search = HplocSearch::automatic;    ///< hploc: see HplocSearch.
    std::uint32_t cluster_limit = 0;  ///< hploc: clusters that a Morton node keeps, 8 or 16; 0: by hploc_quality.
    std::uint32_t small_range = 0;    ///< hploc: Morton nodes of up to so many primitives keep small_limit instead, 1
                                      ///< (none) to 2^30; 0: by hploc_quality.
    std::uint32_t small_limit = 0;    ///< hploc: clusters that a small Morton node keeps, 1 to 8; 0: 8.
    PairMerging merge_pairs = PairMerging::automatic;  ///< hploc: see PairMerging.
    ProgressCallback progress;                         ///< See ProgressCallback; may cancel.
};

/// Throws Error(invalid_input) naming the first option out of its range.
CLBVH_API void check_options(const BuildOptions& options);

[[nodiscard]] CLBVH_API std::string_view to_string(Shape shape) noexcept;      ///< "auto", "group", "lane"
[[nodiscard]] CLBVH_API std::string_view to_string(MortonCode code) noexcept;  ///< "xyz", "extended"
/// "auto", "bits32", "bits64"
[[nodiscard]] CLBVH_API std::string_view to_string(NeighbourEncoding encoding) noexcept;
[[nodiscard]] CLBVH_API std::string_view to_string(NeighbourSearch search) noexcept;  ///< "auto", "symmetric", "scan"
[[nodiscard]] CLBVH_API std::string_view to_string(HplocQuality quality) noexcept;    ///< "balanced", "fast"
[[nodiscard]] CLBVH_API std::string_view to_string(HplocSearch search) noexcept;      ///< "auto", "all-pairs", "window"
[[nodiscard]] CLBVH_API std::string_view to_string(PairMerging merging) noexcept;     ///< "auto", "on", "off"

[[nodiscard]] CLBVH_API std::string_view to_string(OptimizeOn where) noexcept;  ///< "host", "device"

[[nodiscard]] CLBVH_API std::optional<Shape> shape_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<MortonCode> morton_code_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<NeighbourEncoding> neighbour_encoding_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<NeighbourSearch> neighbour_search_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<HplocQuality> hploc_quality_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<HplocSearch> hploc_search_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<PairMerging> pair_merging_from(std::string_view name) noexcept;
[[nodiscard]] CLBVH_API std::optional<OptimizeOn> optimize_on_from(std::string_view name) noexcept;

}  // namespace clbvh
