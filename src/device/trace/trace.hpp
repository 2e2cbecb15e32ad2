#pragma once

#include "clbvh/device/device_tracer.hpp"
#include "device/build/build_buffers.hpp"
#include "device/opencl/launcher.hpp"

namespace clbvh::device {

/// DeviceTracerOptions with everything chosen.
struct TraceSettings {
    TriangleTest triangle_test = TriangleTest::watertight;
    Shape shape = Shape::group;
    std::uint32_t work_group_size = 1;
    std::uint32_t block_rays = 1;
    std::uint32_t stack_entries = 1;
    std::uint32_t persistent_groups = 0;
    bool rounds_divisions = false;  ///< The device can be told to round them correctly.
    bool keeps_denormals = false;
};

/// Throws Error(invalid_input) for options out of range, Error(unsupported) for what the device cannot run.
[[nodiscard]] TraceSettings resolve_trace_settings(Session& session, const DeviceTracerOptions& options);

[[nodiscard]] ProgramSpec trace_program(const TraceSettings& settings);

/// What tracing through a tree of so many nodes takes beside it.
struct TracePlan {
    std::uint32_t deep_items = 0;     ///< Work items for rays that need more than their private stack,
    std::uint32_t deep_capacity = 0;  ///< and the entries of each: one a sibling pair, so that none needs more.

    static constexpr std::uint64_t kControlBytes = 64;
    static constexpr std::uint64_t kEntryBytes = 8;
    [[nodiscard]] std::uint64_t scratch_bytes() const noexcept {
        return kControlBytes + kEntryBytes * deep_items * deep_capacity;
    }
};
[[nodiscard]] TracePlan plan_trace(std::uint32_t node_count);

/// A copy of a scene that is laid out for speed, one part behind the other: the triangles in the order of the leaves
/// (kernels/trace/leaf_triangle.clh), then in the lane shape the header, the nodes and the blocks of a tree with eight
/// children a node (kernels/trace/wide_tree.clh). A tree with so many small leaves that it would take more memory gets
/// none.
struct CopyPlan {
    std::uint64_t rows_bytes = 0;
    bool is_wide = false;
    std::uint32_t node_capacity = 0, block_capacity = 0;

    static constexpr std::uint64_t kRowsBytes = 48;
    static constexpr std::uint64_t kHeaderBytes = 64;
    static constexpr std::uint64_t kNodeBytes = 224;
    static constexpr std::uint64_t kBlockBytes = 160;
    [[nodiscard]] std::uint64_t header_offset() const noexcept { return (rows_bytes + 63) / 64 * 64; }
    [[nodiscard]] std::uint64_t nodes_offset() const noexcept { return header_offset() + kHeaderBytes; }
    [[nodiscard]] std::uint64_t blocks_offset() const noexcept {
        return nodes_offset() + (kNodeBytes * node_capacity + 63) / 64 * 64;
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept {
        return is_wide ? blocks_offset() + kBlockBytes * block_capacity : rows_bytes;
    }
};
[[nodiscard]] CopyPlan plan_copy(const TraceSettings& settings, std::uint32_t reference_count);

/// What rays are traced through.
struct TraceScene {
    std::uint32_t node_count = 0;  ///< Where there are none the buffers may be null.
    std::uint32_t reference_count = 0;
    Block nodes, primitive_ids;
    DeviceMesh mesh;
    Block copy;  ///< Without a buffer the triangles come from the mesh.
};

struct TraceRays {
    std::uint32_t count = 0;
    bool any = false;  ///< A byte each, else a Hit.
    Block rays, results, scratch;
    Block counts;  ///< May have no buffer.
};

/// Fills `copy` from the scene's tree and mesh. Three launches at most, none where there are no references.
void launch_copy(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const Block& copy);

/// Four launches at most, none where there are no rays. Rays that nobody counts go through the tree of eight children,
/// where the copy has one.
void launch_trace(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const TraceRays& rays);

}  // namespace clbvh::device
