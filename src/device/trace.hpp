#pragma once

#include "clbvh/device/device_tracer.hpp"
#include "device/build_buffers.hpp"
#include "device/launcher.hpp"

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

/// Bytes of a reference's triangle in the order of the leaves; LEAF_ROWS of kernels/leaf_triangle.clh.
inline constexpr std::uint64_t kLeafTriangleBytes = 48;

/// What rays are traced through.
struct TraceScene {
    std::uint32_t node_count = 0;  ///< Where there are none the buffers may be null.
    std::uint32_t reference_count = 0;
    Block nodes, primitive_ids;
    DeviceMesh mesh;
    Block leaf_triangles;  ///< Without a buffer the triangles come from the mesh.
};

struct TraceRays {
    std::uint32_t count = 0;
    bool any = false;  ///< A byte each, else a Hit.
    Block rays, results, scratch;
    Block counts;  ///< May have no buffer.
};

/// The same tree with eight children a node, for the lane shape; see kernels/wide_tree.clh.
struct WideScene {
    cl::Buffer nodes, blocks;  ///< Null where there is none.
};

/// The triangles of the scene's mesh into `out`. One launch, none where there are no references.
void launch_leaf_triangles(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene,
                           const Block& out);

/// Three launches, none where there are no rays. Rays go through `wide` where there is one and nobody counts.
void launch_trace(Launcher& launcher, const TraceSettings& settings, const TraceScene& scene, const TraceRays& rays,
                  const WideScene& wide = {});

}  // namespace clbvh::device
