#include "embree/embree_scene.hpp"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "embree/embree_device.hpp"
#include "embree/padded_vertices.hpp"

namespace clbvh::tool {
namespace {

using Geometry = EmbreeHandle<RTCGeometry, rtcReleaseGeometry>;
using Scene = EmbreeHandle<RTCScene, rtcReleaseScene>;

RTCRay to_embree(const Ray& ray) {
    RTCRay result{};
    result.org_x = ray.origin.x;
    result.org_y = ray.origin.y;
    result.org_z = ray.origin.z;
    result.tnear = ray.t_min;
    result.dir_x = ray.direction.x;
    result.dir_y = ray.direction.y;
    result.dir_z = ray.direction.z;
    result.tfar = ray.t_max;
    result.mask = 0xFFFFFFFFU;
    return result;
}

class EmbreeSceneContestant final : public FirstRayContestant {
public:
    EmbreeSceneContestant(std::string_view id, RTCBuildQuality quality, const BuildOptions& options, const Mesh& mesh)
        : FirstRayContestant(id),
          id_(id),
          quality_(quality),
          mesh_(mesh),
          vertices_(padded_vertices(mesh)),
          arena_(static_cast<int>(host_threads(options))) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits) override {
        for (std::size_t i = 0; i < rays.size(); ++i)
            hits[i] = closest(rays[i]);
    }
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            RTCRay ray = to_embree(rays[i]);
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcOccluded1(scene_.get(), &context, &ray);
            is_hit[i] = ray.tfar < 0.0f ? 1 : 0;
        }
    }
    void closest_singly(std::span<const Ray> rays, std::span<Hit> hits) override { closest(rays, hits); }
    void any_singly(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) override { any(rays, is_hit); }
    [[nodiscard]] bool has_span_calls() const noexcept override { return false; }

protected:
    void build_and_trace() override {
        if (!device_) device_.emplace(id_);
        scene_ = Scene(rtcNewScene(device_->get()));
        device_->require(scene_ != nullptr);
        rtcSetSceneBuildQuality(scene_.get(), quality_);
        if (!mesh_.triangles.empty()) attach_geometry();
        arena_.execute([&] { rtcCommitScene(scene_.get()); });
        device_->require_no_error();
        static_cast<void>(closest(Ray{mesh_.vertices.empty() ? Vec3{} : mesh_.vertices.front(), 0.0f, {0, 0, 1}}));
    }
    void describe(FirstRayResult& result) const override { result.is_peer = true; }

private:
    void attach_geometry() {
        const Geometry geometry(rtcNewGeometry(device_->get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        device_->require(geometry != nullptr);
        rtcSetGeometryBuildQuality(geometry.get(), quality_);
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0,
                                   sizeof(Vec3), mesh_.vertices.size());
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh_.triangles.data(),
                                   0, sizeof(Triangle), mesh_.triangles.size());
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(scene_.get(), geometry.get());
    }

    [[nodiscard]] Hit closest(const Ray& ray) const {
        RTCRayHit hit;
        hit.ray = to_embree(ray);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_.get(), &context, &hit);
        return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? Hit{}
                                                         : Hit{hit.ray.tfar, hit.hit.u, hit.hit.v, hit.hit.primID};
    }

    std::string_view id_;
    RTCBuildQuality quality_;
    const Mesh& mesh_;
    std::vector<Vec3> vertices_;
    tbb::task_arena arena_;
    std::optional<EmbreeDevice> device_;  // made by the first, cold run
    Scene scene_;
};

}  // namespace

FirstRayEntrants make_embree_scenes(const BuildOptions& options, const Mesh& mesh) {
    FirstRayEntrants entrants;
    entrants.push_back(std::make_unique<EmbreeSceneContestant>("embree-low", RTC_BUILD_QUALITY_LOW, options, mesh));
    entrants.push_back(
        std::make_unique<EmbreeSceneContestant>("embree-medium", RTC_BUILD_QUALITY_MEDIUM, options, mesh));
    entrants.push_back(std::make_unique<EmbreeSceneContestant>("embree-high", RTC_BUILD_QUALITY_HIGH, options, mesh));
    return entrants;
}

}  // namespace clbvh::tool
