#pragma once

#include <cstdint>

#include "device/build_settings.hpp"
#include "device/session.hpp"

namespace clbvh::device {

/// A triangle mesh in device memory.
struct DeviceMesh {
    cl::Buffer vertices;   ///< float [vertices * 3]
    cl::Buffer triangles;  ///< uint [primitive_count * 3]
    std::uint32_t primitive_count = 0;
    std::uint32_t active_count = 0;  ///< Primitives without a NaN; the leaves of the tree.
};

/// Device memory of one build over n primitives. Names that share memory are never alive together:
///
///     nodes      64 n   primitive boxes (24 n) until the leaves are gathered, then the tree
///     inner      32 n   sort pairs (2 x 8 n) and code halves (2 x 4 n) until the sort ends, then inner clusters
///     references  8 n   the sorted codes until the ranges are cut (lbvh: to the end), then two reference arrays
///     leaves     24 n   boxes in Morton order
///     ids         4 n   primitive ids in Morton order
///
/// 132 bytes a primitive with the finished tree, beside what a builder adds in `extra` and small change.
struct BuildBuffers {
    cl::Buffer nodes, primitive_ids, leaves, inner, references, small, extra;

    // Views, cut out of the buffers above.
    cl::Buffer boxes;                       ///< float [n * 6], in nodes
    cl::Buffer pairs_a, pairs_b;            ///< uint2 [n], in inner
    cl::Buffer code_low, code_high;         ///< uint [n], in inner
    cl::Buffer codes;                       ///< ulong [n], all of references
    cl::Buffer references_a, references_b;  ///< uint [n], in references
    cl::Buffer bounds;                      ///< float [12], in small
    cl::Buffer partial_bounds;              ///< float [12 * kMostPieces], in small
    cl::Buffer counts;                      ///< uint [256 * pieces of the sort, at least kMostPieces], in small
    cl::Buffer morton_tables;               ///< ulong [4096] in small
    cl::Buffer morton_parameters;           ///< float [16], in small
    cl::Buffer root_reference;              ///< uint, in small
    cl::Buffer remaining;                   ///< uint, in small

    std::uint64_t bytes = 0;  ///< What a build over n needs, whatever more is kept from a larger one.

    /// Most pieces that any stage is cut into.
    static constexpr std::uint32_t kMostPieces = 1024;

    /// Makes room for `primitives` (at least 1) and `extra_bytes` more. Memory only grows; all or nothing. The settings
    /// are the same in every call. Throws Error(unsupported) where a buffer would exceed the device's largest
    /// allocation, Error(out_of_memory) where the device has no more.
    void reserve(Session& session, const BuildSettings& settings, std::uint32_t primitives, std::uint64_t extra_bytes);

private:
    std::uint64_t capacity_ = 0;
    std::uint64_t extra_capacity_ = 0;
};

/// Part of `parent` as a buffer of its own. `offset` is a multiple of the device's alignment (see align_for_views).
[[nodiscard]] cl::Buffer view_of(const cl::Buffer& parent, std::uint64_t offset, std::uint64_t bytes);

/// `bytes` rounded up so that the next view may begin there.
[[nodiscard]] constexpr std::uint64_t align_for_views(std::uint64_t bytes) {
    return (bytes + 4095) / 4096 * 4096;
}

}  // namespace clbvh::device
