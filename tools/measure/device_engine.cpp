#include <clbvh/core/error.hpp>
#include <clbvh/device/device_tracer.hpp>

#include "measure/ray_engine.hpp"

namespace clbvh::tool {
namespace {

constexpr std::size_t kDeviceRays = std::size_t{1} << 20;  // what DeviceTracer takes at a time

class DeviceEngine final : public RayEngine {
public:
    DeviceEngine(const Context& context, const Bvh& bvh, const Mesh& mesh, const DeviceTracerOptions& options)
        : tracer_(context, options) {
        tracer_.set_scene(bvh, mesh);
    }

    [[nodiscard]] std::size_t rays_at_once() const override { return kDeviceRays; }
    void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) override {
        tracer_.closest(rays, hits, counts);
    }
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) override {
        tracer_.any(rays, is_hit, counts);
    }
    void visits(std::span<const Ray>, std::span<RayCounts>) override {
        throw Error(ErrorCode::unsupported,
                    "what rays would visit if nothing ended them is counted on the host only: leave --tracer out");
    }

private:
    DeviceTracer tracer_;
};

}  // namespace

std::unique_ptr<RayEngine> make_device_engine(const Context& context, const Bvh& bvh, const Mesh& mesh,
                                              TriangleTest triangle_test) {
    DeviceTracerOptions options;
    options.triangle_test = triangle_test;
    return std::make_unique<DeviceEngine>(context, bvh, mesh, options);
}

}  // namespace clbvh::tool
