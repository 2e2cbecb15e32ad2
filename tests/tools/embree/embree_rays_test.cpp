// The host tracer's hits against those of Embree.
#include <embree3/rtcore.h>

#include <catch2/catch.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/io/scene.hpp>
#include <clbvh/trace/tracer.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>

#include "embree/embree_device.hpp"

using namespace clbvh;
using namespace clbvh::tool;

namespace {

/// The mesh as a robust scene of Embree.
class EmbreeScene {
public:
    explicit EmbreeScene(const Mesh& mesh) : device_("embree"), scene_(rtcNewScene(device_.get())) {
        rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
        const EmbreeHandle<RTCGeometry, rtcReleaseGeometry> geometry(
            rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        copy(geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.vertices);
        copy(geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles);
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(scene_.get(), geometry.get());
        rtcCommitScene(scene_.get());
        device_.require_no_error();
    }

    [[nodiscard]] Hit closest(const Ray& ray) const {
        RTCRayHit query{};
        query.ray = {ray.origin.x,
                     ray.origin.y,
                     ray.origin.z,
                     ray.t_min,
                     ray.direction.x,
                     ray.direction.y,
                     ray.direction.z,
                     0.0f,
                     ray.t_max,
                     ~0u,
                     0,
                     0};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_.get(), &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        return {query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID};
    }

private:
    template <typename Element>
    static void copy(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const std::vector<Element>& from) {
        void* const to = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Element), from.size());
        REQUIRE(to != nullptr);
        std::memcpy(to, from.data(), from.size() * sizeof(Element));
    }

    EmbreeDevice device_;
    EmbreeHandle<RTCScene, rtcReleaseScene> scene_;
};

/// Rays between points of the mesh's box.
std::vector<Ray> rays_through(const Mesh& mesh, std::size_t count) {
    Aabb box;
    for (const Vec3& vertex : mesh.vertices)
        box = merge(box, vertex);
    std::mt19937 random(1);
    const auto between = [&](float low, float high) {
        return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
    };
    const auto point = [&] {
        const float x = between(box.lower.x, box.upper.x), y = between(box.lower.y, box.upper.y);
        return Vec3{x, y, between(box.lower.z, box.upper.z)};
    };
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const Vec3 from = point(), to = point();
        rays.push_back({from, 0.0f, {to.x - from.x, to.y - from.y, to.z - from.z}});
    }
    return rays;
}

/// How far apart the t of hits of one triangle may be. Embree takes t from the triangle's plane, the watertight test
/// from its vertices, so that its rounding is relative to the triangle's extent; rays here are as long as the scene.
constexpr float kSameTriangle = 1e-4f;
/// How far apart, relative to t, hits of two triangles may be that are at one place, such as a common edge.
constexpr float kSamePlace = 1e-5f;

void expect_embrees_hits(const std::string& scene) {
    const Mesh mesh = load_scene(scene);
    const EmbreeScene embree(mesh);
    const std::vector<Ray> rays = rays_through(mesh, 100000);
    BuildOptions options;
    options.max_leaf_size = 4;
    for (const char* builder : {"binned-sah", "sbvh"}) {
        const Tracer tracer(build(mesh, builder, options), mesh);
        std::size_t hits = 0, other_triangles = 0, mismatches = 0;
        for (const Ray& ray : rays) {
            const Hit expected = embree.closest(ray), hit = tracer.closest(ray);
            hits += hit ? 1 : 0;
            const float larger = std::max(hit.t, expected.t), distance = std::abs(hit.t - expected.t);
            if (hit.primitive == expected.primitive) {
                mismatches += hit && distance > kSameTriangle * std::max(1.0f, larger) ? 1 : 0;
            } else if (hit && expected && distance <= kSamePlace * larger) {
                ++other_triangles;
            } else {
                ++mismatches;
            }
        }
        INFO(scene << ", " << builder << ": " << hits << " of " << rays.size() << " rays hit, " << other_triangles
                   << " another triangle at the same place, " << mismatches << " elsewhere");
        CHECK(mismatches == 0);
    }
}

}  // namespace

TEST_CASE("the host tracer hits what Embree hits, on generated scenes") {
    for (const char* scene : {"gen:soup:20000", "gen:terrain:20000", "gen:sphere:20000", "gen:city:20000"})
        expect_embrees_hits(scene);
}

TEST_CASE("the host tracer hits what Embree hits, on real meshes") {
    const char* const folder = std::getenv("CLBVH_SCENES");
    if (folder == nullptr || *folder == '\0') {
        WARN("SKIPPED: CLBVH_SCENES names no folder of meshes");
        return;
    }
    for (const char* name : {"bunny.ply", "kitchen_obvhs.ply", "living_room.ply", "staircase.ply"}) {
        const std::filesystem::path path = std::filesystem::path(folder) / name;
        if (std::filesystem::exists(path)) {
            expect_embrees_hits(path.string());
        } else {
            WARN("SKIPPED: there is no " << path);
        }
    }
}
