#pragma once

#include "device/trace/layout.hpp"

namespace clbvh::device {

enum class DepthFirstKind { skip, pair };

/// A SkipLayout or PairLayout (clbvh/layout/) in device memory, with room for any tree of so many nodes and references.
struct DepthFirstParts {
    Block header, nodes, primitive_ids;
    Block parents, below, places, next_places, top;  ///< What making it takes.
    std::uint64_t bytes = 0;
};
/// Without a place only its sizes.
[[nodiscard]] DepthFirstParts lay_out_depth_first(DepthFirstKind kind, std::uint32_t node_count,
                                                  std::uint32_t reference_count, const Block& place = {});

[[nodiscard]] ProgramSpec depth_first_program(const LayoutSettings& settings);

/// Makes the layout at `scene.layout`, within a stage of the launcher's; the mesh is not looked at. Four launches, and
/// one for each bit of the number of nodes; none where there are no references.
void launch_depth_first(Launcher& launcher, const LayoutSettings& settings, DepthFirstKind kind,
                        const TraceScene& scene);

}  // namespace clbvh::device
