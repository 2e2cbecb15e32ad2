#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/device/memory.hpp"
#include "clbvh/export.h"
#include "clbvh/options.hpp"

namespace clbvh {

/// The primitives of one tree among those of a batch; four words, the same on host and device.
struct BatchRange {
    std::uint32_t first_primitive = 0;  ///< Its results begin there too: nodes at twice as many, ids at as many.
    std::uint32_t primitive_count = 0;
    std::uint32_t first_vertex = 0;  ///< Added to the vertex indices of its triangles.
    std::uint32_t unused = 0;
};

/// The trees of a batch, in device memory.
struct DeviceBatch {
    std::uint32_t tree_count = 0;
    DeviceSpan ranges;  ///< BatchRange [tree_count]; no two may share a primitive, all lie within the input.
};

/// Builds many small trees in one launch, one work group each: for meshes of up to a few thousand triangles, where
/// launches and waits would cost more than the work. Each tree is, byte for byte, the one that Builder("plocpp") makes
/// of the same mesh. Meshes of any size are built right, but a large one keeps a single work group busy.
///
/// One thread at a time for all that shares the Context.
class CLBVH_API BatchBuilder {
public:
    /// Opens the default device. Throws what DeviceBuilder's constructor throws, and Error(unsupported) for extended
    /// Morton codes and 63 code bits.
    explicit BatchBuilder(const BuildOptions& options = {});
    explicit BatchBuilder(Context context, const BuildOptions& options = {});
    BatchBuilder(const BatchBuilder&) = delete;
    BatchBuilder(BatchBuilder&&) noexcept;
    BatchBuilder& operator=(const BatchBuilder&) = delete;
    BatchBuilder& operator=(BatchBuilder&&) noexcept;
    ~BatchBuilder();

    /// One tree for each mesh, which may lie in memory in any way that a view can say; a Mesh becomes a view for free.
    /// Each array is copied once, to where the device reads it. Throws Error(invalid_input) that names the first mesh
    /// and triangle that check_mesh refuses, and Error(unsupported) where all together need more memory than the device
    /// allocates at once, or have 2^32 vertices. Keeps its memory for the next call.
    [[nodiscard]] std::vector<Bvh> build(std::span<const MeshView> meshes, BuildStats* stats = nullptr);

    /// Memory that enqueue() needs for so many primitives and trees; throws as DeviceBuilder::sizes.
    [[nodiscard]] DeviceBuildSizes sizes(std::uint64_t primitive_count, std::uint64_t tree_count) const;
    /// As DeviceBuilder::alignment; for DeviceResult::active_count as well.
    [[nodiscard]] std::uint64_t alignment() const noexcept;

    /// Enqueues the trees of `batch` over the primitives of `input`, as DeviceBuilder::enqueue does one tree, and with
    /// the same contract: neither the values in the input nor those in the ranges are checked. Nodes are numbered from
    /// the first of their tree on, and ids from its first primitive on. DeviceResult::active_count, which must be
    /// there, is one uint a tree.
    void enqueue(cl_command_queue queue, const DeviceInput& input, const DeviceBatch& batch, const DeviceSpan& scratch,
                 const DeviceResult& result, EventList wait_list = {}, cl_event* event = nullptr);

    [[nodiscard]] const BuildOptions& options() const noexcept;
    [[nodiscard]] const Context& context() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clbvh
