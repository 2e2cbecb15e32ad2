#include "build/presplit_stage.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "host/split/quota_split.hpp"

namespace clbvh {

void PresplitStage::run(const MeshView& mesh, double end) {
    host::HostStages stages(options_.progress);
    stages.begin("presplit", 0.0, end, mesh.triangle_count);
    if (options_.split_quota > 0.0f) {
        host::split_to_quota(mesh, options_.split_quota, stages, parts_);
    } else {
        PresplitConfig config;
        config.level = options_.presplit_level;
        host::presplit(mesh, config, stages, parts_);
    }
    if (row_.clips_triangles) name_triangles(mesh);
    stats_ = stages.finish();
    stats_.peak_host_bytes = parts_.boxes.size() * sizeof(Aabb) + parts_.source.size() * sizeof(std::uint32_t) +
                             indices_.size() * sizeof(Triangle);
    if (options_.split_quota > 0.0f) stats_.peak_host_bytes += mesh.triangle_count * host::SplitPlan::kBytesPerTriangle;
}

void PresplitStage::name_triangles(const MeshView& mesh) {
    indices_.resize(parts_.source.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, indices_.size(), 8192), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            indices_[i] = mesh.triangle(parts_.source[i]);
    });
    triangles_ = MeshView{mesh.vertices, mesh.vertex_count, mesh.vertex_stride, indices_.data(), indices_.size()};
}

void PresplitStage::book(BuildStats& stats) const {
    stats.stages.insert(stats.stages.begin(), stats_.stages.begin(), stats_.stages.end());
    stats.build_ms += stats_.build_ms;
    stats.peak_host_bytes += stats_.peak_host_bytes;
}

}  // namespace clbvh
