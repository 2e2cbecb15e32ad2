#include "embree/embree_commit.hpp"

#include <tbb/task_arena.h>

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/interrupt.hpp"
#include "cli/stopwatch.hpp"
#include "embree/embree_device.hpp"
#include "embree/padded_vertices.hpp"

namespace clbvh::tool {
namespace {

constexpr std::string_view kId = "embree-commit-low";

using Geometry = EmbreeHandle<RTCGeometry, rtcReleaseGeometry>;
using Scene = EmbreeHandle<RTCScene, rtcReleaseScene>;

class EmbreeCommit final : public TreeContestant {
public:
    EmbreeCommit(const BuildOptions& options, const Mesh& mesh)
        : mesh_(mesh),
          vertices_(padded_vertices(mesh)),
          inactive_count_(check_mesh(mesh)),
          thread_count_(host_threads(options)),
          arena_(static_cast<int>(thread_count_)),
          device_(kId),
          geometry_(make_geometry()),
          scene_(make_scene()) {}

    [[nodiscard]] std::string_view name() const override { return kId; }

    [[nodiscard]] BuildResult result() const override {
        BuildResult result;
        summarize_runs(result, runs());
        result.builder = kId;
        result.kind = BuilderKind::host;
        result.is_peer = true;
        result.threads = thread_count_;
        return result;
    }

    [[nodiscard]] std::optional<Bvh> tree() const override { return std::nullopt; }

protected:
    BuildStats build() override {
        if (geometry_) mark_changed();
        const Stopwatch stopwatch;
        arena_.execute([&] { rtcCommitScene(scene_.get()); });
        BuildStats stats;
        stats.build_ms = stopwatch.milliseconds();
        device_.require_no_error();
        stats.stages = {{"commit", 0.0, stats.build_ms, 0}};
        stats.peak_host_bytes = device_.peak_bytes();
        stats.inactive_primitives = inactive_count_;
        return stats;
    }

private:
    [[nodiscard]] Geometry make_geometry() const {
        if (mesh_.triangles.empty()) return nullptr;
        Geometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
        device_.require(geometry != nullptr);
        rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_LOW);
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0,
                                   sizeof(Vec3), mesh_.vertices.size());
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh_.triangles.data(),
                                   0, sizeof(Triangle), mesh_.triangles.size());
        return geometry;
    }

    [[nodiscard]] Scene make_scene() const {
        Scene scene(rtcNewScene(device_.get()));
        device_.require(scene != nullptr);
        rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_DYNAMIC);
        rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_LOW);
        rtcSetSceneProgressMonitorFunction(
            scene.get(), [](void*, double) { return !interrupted(); }, nullptr);
        if (geometry_) rtcAttachGeometry(scene.get(), geometry_.get());
        return scene;
    }

    void mark_changed() const {
        rtcUpdateGeometryBuffer(geometry_.get(), RTC_BUFFER_TYPE_VERTEX, 0);
        rtcUpdateGeometryBuffer(geometry_.get(), RTC_BUFFER_TYPE_INDEX, 0);
        rtcCommitGeometry(geometry_.get());
    }

    const Mesh& mesh_;
    std::vector<Vec3> vertices_;
    std::uint64_t inactive_count_;
    std::uint32_t thread_count_;
    tbb::task_arena arena_;
    EmbreeDevice device_;
    Geometry geometry_;  // null where the mesh is empty
    Scene scene_;
};

}  // namespace

std::unique_ptr<TreeContestant> make_embree_commit(const BuildOptions& options, const Mesh& mesh) {
    return std::make_unique<EmbreeCommit>(options, mesh);
}

}  // namespace clbvh::tool
