#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "device/build/build_settings.hpp"
#include "device/opencl/device_memory.hpp"
#include "device/opencl/device_mesh.hpp"
#include "device/opencl/memory_block.hpp"
#include "host/top_down/cluster_top.hpp"
#include "kernels/cluster/cluster_constants.h"

namespace clbvh::device {

/// In what order a clustering reads the primitives' boxes.
enum class BoxOrder : std::uint8_t {
    morton,  ///< A sorted copy, `leaves`, is made for it.
    input,   ///< It looks them up itself through `primitive_ids`.
};

/// Bytes of each block of a build over n primitives. Names that share memory are never alive together:
///
///     nodes       64 n   until the tree is written, BoxOrder::morton: the primitives' boxes (24 n); input: the sort
///     ids          4 n   primitive ids in Morton order
///     leaves      24 n   morton: boxes in Morton order; input: the primitives' boxes
///     inner       32 n   morton: the sort, then inner clusters; input: nothing, unless n is so small that the sort
///                        does not fit into the nodes
///     references   8 n   the sorted codes; morton: until the ranges are cut, then two reference arrays
///
/// The sort takes 8 n beside the sorted codes, for packed keys, or 24 n: two arrays of pairs and the halves of the
/// codes. With the finished tree that is 132 or 100 bytes a primitive, beside what a builder adds in `extra` and small
/// change.
struct MemoryPlan {
    BoxOrder box_order = BoxOrder::morton;
    std::uint64_t primitives = 0;
    bool packed_keys = true;
    bool recodes = false;
    bool groups_primitives = false;                                             ///< leaves may have several primitives
    std::uint64_t sort_counts = 0;                                              ///< digits times pieces of the sort
    std::uint64_t nodes = 0, primitive_ids = 0;                                 ///< the result
    std::uint64_t leaves = 0, inner = 0, references = 0, small = 0, extra = 0;  ///< scratch

    [[nodiscard]] bool operator==(const MemoryPlan&) const noexcept = default;
    /// Scratch in one piece, see cut_scratch().
    [[nodiscard]] std::uint64_t scratch_bytes() const;
    /// Bytes that a build needs, the finished tree included.
    [[nodiscard]] std::uint64_t bytes() const noexcept {
        return nodes + primitive_ids + leaves + inner + references + small + extra;
    }
};

[[nodiscard]] MemoryPlan plan_memory(const BuildSettings& settings, BoxOrder box_order, std::uint32_t primitives,
                                     std::uint64_t extra_bytes);

/// Throws Error(unsupported) where a block of the plan, or one of `scratch_bytes` beside them, would exceed the
/// device's largest allocation.
void check_allocations(const Session& session, const MemoryPlan& plan, std::uint64_t scratch_bytes = 0);

/// The blocks of one build.
struct BuildMemory {
    Block nodes, primitive_ids, leaves, inner, references, small, extra;
};

/// The blocks of a plan, with all scratch one behind the other in `scratch`.
[[nodiscard]] BuildMemory cut_scratch(const Block& nodes, const Block& primitive_ids, const Block& scratch,
                                      const MemoryPlan& plan);

/// Device memory of one build, as the kernels see it.
struct BuildBuffers {
    cl::Buffer nodes;                       ///< Node [2 * n]
    cl::Buffer primitive_ids;               ///< uint [n]
    cl::Buffer leaves;                      ///< float [n * 6 + 2], BoxOrder::morton only
    cl::Buffer inner;                       ///< float [n * 8], BoxOrder::morton only
    cl::Buffer boxes;                       ///< float [n * 6 + 2], by primitive
    cl::Buffer keys;                        ///< ulong [n], packed keys only, which pass between it and codes
    cl::Buffer pairs_a, pairs_b;            ///< ulong [n], pairs only
    cl::Buffer code_low, code_high;         ///< uint [n], pairs only
    cl::Buffer codes;                       ///< ulong [n]
    cl::Buffer references_a, references_b;  ///< uint [n], BoxOrder::morton only
    cl::Buffer bounds;                      ///< float [12], in small, like all that follow
    cl::Buffer partial_bounds;              ///< float [12 * kMostPieces]
    cl::Buffer partial_counts;              ///< uint [kMostPieces]
    cl::Buffer counts;                      ///< uint [digits * pieces of the sort, at least kMostPieces]
    cl::Buffer morton_tables;               ///< ulong [MORTON_TABLE_ULONGS]
    cl::Buffer morton_parameters;           ///< float [MORTON_PARAMETERS]
    cl::Buffer recode_state;                ///< uint [RECODE_ROUNDS * RECODE_STATE_WORDS], where codes are again coded
    cl::Buffer recode_runs;                 ///< uint [2 * (n / (LONGEST_RUN + 1) + 1)], likewise
    cl::Buffer primitive_count;             ///< uint: active primitives
    cl::Buffer leaf_count;      ///< uint: leaves of the tree; primitive_count itself unless they are grouped
    cl::Buffer root_reference;  ///< uint
    cl::Buffer cluster_counts;  ///< uint [kCountsKept], see kernels/cluster/iteration.clh
    Block extra;                ///< what DeviceAlgorithm::extra_bytes asked for

    static constexpr std::uint32_t kCountsKept = kernels::COUNTS_KEPT;
};

/// The buffers of the boxes of `primitives`, of the bounds of all and of what finding these takes: boxes, bounds,
/// partial_bounds, partial_counts and primitive_count.
[[nodiscard]] BuildBuffers cut_bounds(ArrayLayout& layout, std::uint64_t primitives);

/// Cuts the blocks, each as large as `plan` says or larger, into the views of a build.
[[nodiscard]] BuildBuffers cut_views(const BuildMemory& memory, const MemoryPlan& plan);

/// Memory that stays for the next build.
class OwnMemory {
public:
    /// Makes room for `plan`; does nothing where it is the last one again. Memory only grows; all or nothing. Throws
    /// Error(unsupported) where a block would exceed the device's largest allocation, Error(out_of_memory) where the
    /// device has no more.
    void reserve(Session& session, const MemoryPlan& plan);
    /// The views of the last plan.
    [[nodiscard]] const BuildBuffers& buffers() const noexcept { return buffers_; }
    [[nodiscard]] const BuildMemory& memory() const noexcept { return memory_; }
    /// For what works on the finished tree; at least `bytes`, at least 1.
    [[nodiscard]] Block reserve_tree_scratch(const Session& session, std::uint64_t bytes) {
        return {tree_scratch_.reserve(session, bytes)};
    }

    /// For the host, where it builds the top of the tree.
    [[nodiscard]] host::TopMemory& top() {
        if (top_ == nullptr) top_ = std::make_unique<host::TopMemory>();
        return *top_;
    }

    static constexpr std::size_t kBlocks = 7;

private:
    std::array<KeptBuffer, kBlocks> blocks_;
    BuildMemory memory_;  // these blocks
    MemoryPlan plan_;     // of buffers_
    BuildBuffers buffers_;
    KeptBuffer tree_scratch_;
    std::unique_ptr<host::TopMemory> top_;
};

}  // namespace clbvh::device
