#include "bench/bench_rays.hpp"

#include <clbvh/eval/ray_sets.hpp>
#include <optional>
#include <vector>

#include "measure/ray_engine.hpp"
#include "measure/wide_and_binary.hpp"

namespace clbvh::tool {

void bench_rays(std::span<BuildResult> results, std::span<const std::unique_ptr<TreeContestant>> entrants,
                const Mesh& mesh, const Camera& camera, std::size_t runs, std::uint32_t threads,
                RoundsProgress& progress) {
    std::vector<std::unique_ptr<RayEngine>> engines;
    WideAndBinary traced;
    std::vector<BuildResult*> results_of;
    for (std::size_t i = 0; i < entrants.size(); ++i) {
        if (!results[i].has_tree || !results[i].valid.value_or(true)) continue;
        engines.push_back(make_host_engine(entrants[i]->tree().value(), mesh, {TriangleTest::watertight, threads}));
        traced.add(results[i].builder, *engines.back());
        results_of.push_back(&results[i]);
    }
    if (engines.empty()) return;
    const RaySet set{RayKind::diffuse, make_rays(RayKind::diffuse, mesh, closest_hits_of(*engines.front()), camera,
                                                 {std::uint64_t{1} << 18, 1})};
    if (set.rays.empty()) return;
    traced.measure(*engines.front(), set, runs, progress);
    for (std::size_t i = 0; i < results_of.size(); ++i) {
        results_of[i]->rays = traced.cost(i);
        results_of[i]->binary_ns_per_ray = traced.binary_cost(i).ns_per_ray();
    }
}

}  // namespace clbvh::tool
