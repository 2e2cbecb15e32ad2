#pragma once

#include "device/opencl/device_fit.hpp"
#include "device/opencl/device_mesh.hpp"
#include "device/opencl/launcher.hpp"
#include "device/opencl/memory_block.hpp"
#include "kernels/layout/layout_constants.h"

namespace clbvh::device {

/// Layouts whose nodes have more than two children. Rays go through wide8.
enum class WideKind { wide8, wide4, compressed8 };

/// Such a layout (clbvh/layout/) in device memory: a header, its nodes and blocks, or triangles; of wide8 also which
/// nodes of the binary tree its boxes are from, and for rays that go through two children the triangles in the order of
/// the leaves (kernels/trace/leaf_triangle.clh). There is room for any tree of so many references.
struct WideParts {
    Block header, nodes, blocks, sources, rows;
    Block state, pieces, next_chunks, records;  ///< What making it takes, where the rows are written last.
    std::uint32_t most_pieces = 0;              ///< The top of the tree included.
    std::uint64_t bytes = 0;
};
/// Without a place only its sizes.
[[nodiscard]] WideParts lay_out_wide(WideKind kind, std::uint32_t node_count, std::uint32_t reference_count,
                                     const Block& place = {});

/// A tree, its mesh, and its layout.
struct TraceScene {
    std::uint32_t node_count = 0, reference_count = 0;
    Block nodes, primitive_ids;
    Block active_count;  ///< A uint, half the nodes in use; without a buffer all of node_count may be.
    DeviceMesh mesh;
    Block layout;
};

/// As kernels are told where it is.
[[nodiscard]] kernels::ScenePlace place_of(const TraceScene& scene);
[[nodiscard]] kernels::LayoutPlace place_of(const WideParts& layout);

/// How layouts are made on one device.
struct LayoutSettings {
    std::size_t work_group_size = 1;               ///< 1 in the lane shape.
    std::uint32_t share_groups = 1;                ///< Of passes that are dealt out to any number of groups.
    HandOver hand_over = HandOver::within_launch;  ///< Never automatic.
};
[[nodiscard]] LayoutSettings resolve_layout_settings(Session& session, Shape shape);

[[nodiscard]] ProgramSpec wide_program(const LayoutSettings& settings, WideKind kind);

/// Makes the layout at `scene.layout`, within a stage of the launcher's. Up to five launches, none where there are no
/// references.
void launch_wide(Launcher& launcher, const LayoutSettings& settings, WideKind kind, const TraceScene& scene);

/// Gives the scene's wide8 the boxes of the tree that it was made of, and the vertices of the mesh, within a stage of
/// the launcher's. Two launches, none where there are no references.
void launch_wide_refit(Launcher& launcher, const LayoutSettings& settings, const TraceScene& scene);

}  // namespace clbvh::device
