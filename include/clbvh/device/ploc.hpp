#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh {

/// How the fused kernels of PLOC++ pack a distance and its neighbour into one integer (section 4.3).
enum class NeighbourEncoding : std::uint8_t {
    bits32,  ///< Distance with its lowest mantissa bits replaced by the relative offset.
    bits64,  ///< Exact distance above the offset; the group shape needs 64-bit local atomics, or the scan search.
};

/// How the group shape of PLOC++ finds neighbours in local memory.
enum class NeighbourSearch : std::uint8_t {
    automatic,  ///< symmetric on GPUs, scan on CPU devices, where local atomics cost more than the distances they save.
    symmetric,  ///< Each pair measured once, both sides updated by a local atomic minimum (PLOC++ algorithm 1).
    scan,       ///< Each side measures its own 2 R pairs; no atomics.
};

/// The family of PLOC: ploc, plocpp and plocpp-two-level.
///
/// Meister, Bittner 2018, "Parallel locally-ordered clustering for bounding volume hierarchy construction"; Benthin,
/// Drabinski, Tessari, Dittebrandt 2022, "PLOC++". Only the first of these options changes the tree of ploc, only it,
/// the encoding and range_count those of the others.
struct PlocConfig {
    std::uint32_t search_radius = 16;   ///< R: neighbours searched to each side, 1 to 32.
    std::uint32_t chunk_size = 0;       ///< Clusters per chunk of the lane shape, 64 to 4096 in steps of 64; 0: chosen.
    std::uint32_t work_group_size = 0;  ///< Work items of the group shape, a power of two, 32 to 1024; 0: chosen.
    NeighbourEncoding neighbour_encoding = NeighbourEncoding::bits32;  ///< plocpp, plocpp-two-level.
    NeighbourSearch neighbour_search = NeighbourSearch::automatic;     ///< plocpp, plocpp-two-level.
    std::uint32_t single_group_threshold = 0;  ///< plocpp: clusters below which one work group finishes the tree, 2 to
                                               ///< 2^20; 0: chosen.
    std::uint32_t range_count = 0;  ///< plocpp-two-level: least number of Morton ranges, 1 to 512; 0: chosen.
};

/// "bits32", "bits64"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(NeighbourEncoding encoding) noexcept {
    switch (encoding) {
        case NeighbourEncoding::bits32: return "bits32";
        case NeighbourEncoding::bits64: return "bits64";
    }
    return {};
}

/// "auto", "symmetric", "scan"; empty for what is no enumerator.
[[nodiscard]] constexpr std::string_view to_string(NeighbourSearch search) noexcept {
    switch (search) {
        case NeighbourSearch::automatic: return "auto";
        case NeighbourSearch::symmetric: return "symmetric";
        case NeighbourSearch::scan: return "scan";
    }
    return {};
}

}  // namespace clbvh
