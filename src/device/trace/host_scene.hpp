#pragma once

#include <cstddef>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "device/opencl/device_memory.hpp"
#include "device/trace/trace.hpp"

namespace clbvh::device {

/// A scene of the host that was copied to the device, and memory for rays that stays between calls.
class HostScene {
public:
    /// Rays that are on the device at a time.
    static constexpr std::size_t kMostRays = std::size_t{1} << 20;

    /// Copies the nodes, and the triangles in the order of the leaves; nothing else of the two is needed afterwards.
    /// All numbers in `bvh` and `mesh` are in range. Throws Error(unsupported) where the device cannot allocate as much
    /// at once.
    HostScene(Session& session, const TraceSettings& settings, const Bvh& bvh, const MeshView& mesh);

    /// Fills `results`, a Hit or, with `any`, a byte for each ray, and `counts`, where there are some.
    void trace(Session& session, const TraceSettings& settings, std::span<const Ray> rays, bool any,
               std::span<std::byte> results, std::span<RayCounts> counts);

private:
    void lay_out_triangles(Session& session, const TraceSettings& settings, const Bvh& bvh, const MeshView& mesh);

    TraceScene scene_;
    KeptBuffer rays_, results_, counts_, scratch_;
};

}  // namespace clbvh::device
