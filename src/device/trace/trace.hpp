#pragma once

#include "clbvh/core/ray.hpp"
#include "clbvh/device/tracer_options.hpp"
#include "device/opencl/device_mesh.hpp"
#include "device/opencl/launcher.hpp"
#include "device/opencl/memory_block.hpp"

namespace clbvh::device {

/// DeviceTracerOptions with everything chosen.
struct TraceSettings {
    TriangleTest triangle_test = TriangleTest::watertight;
    Shape shape = Shape::group;
    std::uint32_t work_group_size = 1;
    std::uint32_t block_rays = 1;
    std::uint32_t stack_entries = 1;
    bool rounds_divisions = false;  ///< The device can be told to round them correctly.
    bool keeps_denormals = false;
};

/// Throws Error(invalid_input) for options out of range, Error(unsupported) for what the device cannot run.
[[nodiscard]] TraceSettings resolve_trace_settings(Session& session, const DeviceTracerOptions& options);

[[nodiscard]] ProgramSpec trace_program(const TraceSettings& settings);

/// What tracing through a tree takes beside it.
struct TraceScratch {
    Block control;                    ///< counters
    Block deep;                       ///< stacks for rays that need more than their private one:
    std::uint32_t deep_items = 0;     ///< of so many work items,
    std::uint32_t deep_capacity = 0;  ///< with so many entries each: one a sibling pair, so that none needs more
    std::uint64_t bytes = 0;
};
/// For a tree of so many nodes; without a place only its size.
[[nodiscard]] TraceScratch lay_out_trace_scratch(std::uint32_t node_count, const Block& place = {});

/// A scene as rays go through it fastest: the triangles in the order of the leaves (kernels/trace/leaf_triangle.clh),
/// then in the lane shape the header, the nodes and the blocks of a tree with eight children a node
/// (kernels/trace/wide_tree.clh). A tree with so many small leaves that it would take more memory gets none.
struct TraceLayout {
    Block rows;
    bool is_wide = false;  ///< has what follows
    Block header, nodes, blocks;
    std::uint32_t node_capacity = 0, block_capacity = 0;
    std::uint64_t bytes = 0;
};
/// For a tree of so many references; without a place only its size.
[[nodiscard]] TraceLayout lay_out_scene(const TraceSettings& settings, std::uint32_t reference_count,
                                        const Block& place = {});

/// A scene to trace rays through.
struct TraceScene {
    std::uint32_t node_count = 0;  ///< Where there are none the buffers may be null.
    std::uint32_t reference_count = 0;
    Block nodes, primitive_ids;
    DeviceMesh mesh;
    Block layout;  ///< Where launch_layout() put one; without a buffer the triangles come from the mesh.
};

struct TraceRays {
    std::uint32_t count = 0;
    bool any = false;  ///< A byte each, else a Hit.
    Block rays, results, scratch;
    Block counts;  ///< May have no buffer.
};

/// Puts a traversal layout of the scene's tree and mesh into `place`. Three launches at most, none where there are no
/// references.
void launch_layout(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const Block& place);

/// Four launches at most, none where there are no rays. Rays that are not counted go through the tree of eight
/// children, where the layout has one.
void launch_trace(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const TraceRays& rays);

}  // namespace clbvh::device
