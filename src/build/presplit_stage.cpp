#include "build/presplit_stage.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "host/split/quota_split.hpp"

namespace clbvh {

void PresplitStage::run(const Mesh& mesh, double end) {
    host::HostStages stages(options_.progress);
    stages.begin("presplit", 0.0, end, mesh.triangles.size());
    if (options_.split_quota > 0.0f) {
        host::split_to_quota(mesh, options_.split_quota, stages, parts_);
    } else {
        PresplitConfig config;
        config.level = options_.presplit_level;
        host::presplit(mesh, config, stages, parts_);
    }
    if (row_.clips_triangles) {
        triangles_.vertices = mesh.vertices;
        triangles_.triangles.resize(parts_.source.size());
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, parts_.source.size(), 8192), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i)
                triangles_.triangles[i] = mesh.triangles[parts_.source[i]];
        });
    }
    stats_ = stages.finish();
    stats_.peak_host_bytes = parts_.mesh.vertices.size() * sizeof(Vec3) + parts_.source.size() * sizeof(std::uint32_t) +
                             (parts_.mesh.triangles.size() + triangles_.triangles.size()) * sizeof(Triangle);
    if (options_.split_quota > 0.0f)
        stats_.peak_host_bytes += mesh.triangles.size() * host::SplitPlan::kBytesPerTriangle;
}

void PresplitStage::book(BuildStats& stats) const {
    stats.stages.insert(stats.stages.begin(), stats_.stages.begin(), stats_.stages.end());
    stats.build_ms += stats_.build_ms;
    stats.peak_host_bytes += stats_.peak_host_bytes;
}

}  // namespace clbvh
