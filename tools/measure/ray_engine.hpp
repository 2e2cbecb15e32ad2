#pragma once

#include <clbvh/core/bvh.hpp>
#include <clbvh/core/mesh.hpp>
#include <clbvh/core/ray.hpp>
#include <clbvh/device/context.hpp>
#include <clbvh/eval/camera.hpp>
#include <clbvh/trace/binary_tracer.hpp>
#include <clbvh/trace/tracer.hpp>
#include <cstdint>
#include <memory>
#include <span>

namespace clbvh::tool {

/// A tracer of rays through one tree: the host, or an OpenCL device. The hits are the same.
class RayEngine {
public:
    RayEngine() = default;
    RayEngine(const RayEngine&) = delete;
    RayEngine& operator=(const RayEngine&) = delete;
    virtual ~RayEngine() = default;

    /// How many rays a call should have at most, so that it ends soon, and at least, so that the call costs nothing
    /// beside them.
    [[nodiscard]] virtual std::size_t rays_at_once() const = 0;
    /// The spans have the same length; `counts` may be empty instead.
    virtual void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) = 0;
    /// 1 or 0 each.
    virtual void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) = 0;
    /// Counts of what the rays would visit if nothing ended them. Throws Error(unsupported) on a device.
    virtual void visits(std::span<const Ray> rays, std::span<RayCounts> counts) = 0;
};

/// On the host, over a copy of what it needs.
[[nodiscard]] std::unique_ptr<RayEngine> make_host_engine(const Bvh& bvh, const Mesh& mesh,
                                                          const TracerOptions& options);

/// On the device of `context`, over a copy in its memory.
[[nodiscard]] std::unique_ptr<RayEngine> make_device_engine(const Context& context, const Bvh& bvh, const Mesh& mesh,
                                                            TriangleTest triangle_test);

/// Asks `engine`, which has to outlive the result.
[[nodiscard]] ClosestHits closest_hits_of(RayEngine& engine);

}  // namespace clbvh::tool
