#include "device/trace/host_scene.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/error.hpp"
#include "device/opencl/host_primitives.hpp"

namespace clbvh::device {
namespace {

void check_fits(const Session& session, const char* what, std::uint64_t count, std::uint64_t each) {
    const std::uint64_t most = session.info().max_allocation_bytes;
    if (count * each <= most) return;
    throw Error(ErrorCode::unsupported, std::to_string(count) + " " + what + " are too many for " +
                                            session.info().name + ", which allocates at most " + std::to_string(most) +
                                            " bytes at once: enough for " + std::to_string(most / each) +
                                            "; trace in parts");
}

template <typename T>
cl::Buffer upload(Session& session, std::span<const T> values) {
    cl::Buffer buffer = allocate_buffer(session, values.size_bytes());
    session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, values.size_bytes(), values.data());
    return buffer;
}

template <typename T>
std::span<const T> as_span(const std::vector<T>& values) {
    return values;
}

}  // namespace

HostScene::HostScene(Session& session, const TraceSettings& settings, const Bvh& bvh, const MeshView& mesh) {
    if (bvh.empty()) return;
    check_fits(session, "nodes", bvh.nodes.size(), sizeof(Node));
    check_fits(session, "references", bvh.primitive_ids.size(), lay_out_wide(WideKind::wide8, 2000, 1000).bytes / 1000);
    check_fits(session, "vertices", mesh.vertex_count, mesh.vertex_stride);
    check_fits(session, "triangles", mesh.triangle_count, mesh.bytes_between_triangles());
    with_opencl_errors("copying a scene to the device", [&] {
        scene_.node_count = static_cast<std::uint32_t>(bvh.nodes.size());
        scene_.nodes = {upload(session, as_span(bvh.nodes))};
        lay_out_triangles(session, settings, bvh, mesh);
    });
}

void HostScene::lay_out_triangles(Session& session, const TraceSettings& settings, const Bvh& bvh,
                                  const MeshView& mesh) {
    scene_.reference_count = static_cast<std::uint32_t>(bvh.primitive_ids.size());
    const WideParts parts = lay_out_wide(WideKind::wide8, scene_.node_count, scene_.reference_count);
    scene_.layout = {allocate_buffer(session, parts.bytes)};
    TraceScene from_mesh = scene_;
    from_mesh.primitive_ids = {upload(session, as_span(bvh.primitive_ids))};
    from_mesh.mesh = bind_primitives(session, mesh, mesh.triangle_count);
    Launcher launcher(session, session.queue(), {});
    launcher.begin_stage("layout", 0.0);
    launch_wide(launcher, settings.layout, WideKind::wide8, from_mesh);
    session.queue().finish();
}

void HostScene::trace(Session& session, const TraceSettings& settings, std::span<const Ray> rays, bool any,
                      std::span<std::byte> results, std::span<RayCounts> counts) {
    const std::size_t result_bytes = any ? 1 : sizeof(Hit);
    for (std::size_t begin = 0; begin < rays.size(); begin += kMostRays) {
        const std::size_t count = std::min(kMostRays, rays.size() - begin);
        const cl::CommandQueue& queue = session.queue();
        TraceRays part;
        part.count = static_cast<std::uint32_t>(count);
        part.any = any;
        part.rays = {rays_.reserve(session, count * sizeof(Ray))};
        part.results = {results_.reserve(session, count * result_bytes)};
        part.scratch = {scratch_.reserve(session, lay_out_trace_scratch(scene_.node_count).bytes)};
        if (!counts.empty()) part.counts = {counts_.reserve(session, count * sizeof(RayCounts))};
        queue.enqueueWriteBuffer(part.rays.buffer, CL_TRUE, 0, count * sizeof(Ray), rays.data() + begin);
        Launcher launcher(session, queue, {});
        launch_trace(launcher, settings, scene_, part);
        queue.finish();
        queue.enqueueReadBuffer(part.results.buffer, CL_TRUE, 0, count * result_bytes,
                                results.data() + begin * result_bytes);
        if (!counts.empty()) {
            queue.enqueueReadBuffer(part.counts.buffer, CL_TRUE, 0, count * sizeof(RayCounts), counts.data() + begin);
        }
    }
}

}  // namespace clbvh::device
