#include "measure/ray_engine.hpp"

namespace clbvh::tool {
namespace {

constexpr std::size_t kHostRays = std::size_t{1} << 14;  // milliseconds

class HostEngine final : public RayEngine {
public:
    HostEngine(const Bvh& bvh, const Mesh& mesh, const TracerOptions& options)
        : tracer_(bvh, mesh, options), binary_tracer_(bvh, mesh, options) {}

    [[nodiscard]] std::size_t rays_at_once() const override { return kHostRays; }
    void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) override {
        if (counts.empty()) {
            tracer_.closest(rays, hits);
        } else {
            binary_tracer_.closest(rays, hits, counts);
        }
    }
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) override {
        if (counts.empty()) {
            tracer_.any(rays, is_hit);
        } else {
            binary_tracer_.any(rays, is_hit, counts);
        }
    }
    void visits(std::span<const Ray> rays, std::span<RayCounts> counts) override {
        binary_tracer_.visits(rays, counts);
    }

private:
    Tracer tracer_;
    BinaryTracer binary_tracer_;
};

}  // namespace

std::unique_ptr<RayEngine> make_host_engine(const Bvh& bvh, const Mesh& mesh, const TracerOptions& options) {
    return std::make_unique<HostEngine>(bvh, mesh, options);
}

ClosestHits closest_hits_of(RayEngine& engine) {
    return [&engine](std::span<const Ray> rays, std::span<Hit> hits) { engine.closest(rays, hits, {}); };
}

}  // namespace clbvh::tool
