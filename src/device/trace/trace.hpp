#pragma once

#include "clbvh/core/ray.hpp"
#include "clbvh/device/tracer_options.hpp"
#include "device/opencl/device_mesh.hpp"
#include "device/opencl/launcher.hpp"
#include "device/opencl/memory_block.hpp"
#include "device/trace/layout.hpp"

namespace clbvh::device {

/// DeviceTracerOptions with everything chosen.
struct TraceSettings {
    TriangleTest triangle_test = TriangleTest::watertight;
    Shape shape = Shape::group;
    std::uint32_t work_group_size = 1;
    std::uint32_t block_rays = 1;
    std::uint32_t stack_entries = 1;
    LayoutSettings layout;
    bool rounds_divisions = false;  ///< The device can be told to round them correctly.
    bool keeps_denormals = false;
};

/// Throws Error(invalid_input) for options out of range, Error(unsupported) for what the device cannot run.
[[nodiscard]] TraceSettings resolve_trace_settings(Session& session, const DeviceTracerOptions& options);

/// Without what makes layouts.
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

struct TraceRays {
    std::uint32_t count = 0;
    bool any = false;  ///< A byte each, else a Hit.
    Block rays, results, scratch;
    Block counts;  ///< May have no buffer.
};

/// Four launches at most, none where there are no rays. Rays that are not counted go through the layout's eight
/// children, where there is one, which is of a tree with as many nodes and references; others take triangles from its
/// rows. Without a layout these come from the mesh. A scene without nodes needs no buffers.
void launch_trace(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const TraceRays& rays);

}  // namespace clbvh::device
