#include "host/build/host_build.hpp"

#include "core/memory_errors.hpp"
#include "core/primitive_limit.hpp"
#include "core/simd/dispatch.hpp"
#include "host/build/primitive_bounds.hpp"

namespace clbvh::host {
namespace {

/// The build from references to the result; empty where there are none.
BuildStats run_algorithm(std::span<Reference> references, const Bounds& bounds, const Mesh* mesh,
                         const BoundAlgorithm& algorithm, Scratch& scratch, HostStages& stages, Bvh& result) {
    simd::check_instruction_set();
    result.split_references = false;
    if (references.empty()) {
        result.nodes.clear();
        result.primitive_ids.clear();
    } else {
        HostBuild build{references, bounds, mesh, scratch, stages, result};
        algorithm(build);
    }
    BuildStats stats = stages.finish();
    stats.peak_host_bytes = scratch.bytes_in_use() + result.nodes.size() * sizeof(Node) +
                            result.primitive_ids.size() * sizeof(std::uint32_t);
    return stats;
}

}  // namespace

BuildStats run_host_build(const HostInput& input, const BoundAlgorithm& algorithm, const ProgressCallback& progress,
                          Scratch& scratch, Bvh& result) {
    HostStages stages(progress);
    scratch.reset();
    stages.begin("bounds", 0.0, 0.05);
    const std::span<Reference> references = scratch.take<Reference>(input.active_count);
    const Bounds bounds = bound_primitives(input.boxes, references, scratch);
    result.primitive_count = input.boxes.triangles.size();
    BuildStats stats = run_algorithm(references, bounds, &input.triangles, algorithm, scratch, stages, result);
    stats.inactive_primitives = input.boxes.triangles.size() - input.active_count;
    return stats;
}

Bvh build_over_mesh(const Mesh& mesh, const BoundAlgorithm& algorithm) {
    const std::uint64_t inactive = check_mesh(mesh);
    return with_memory_errors("the build", [&] {
        Scratch scratch;
        Bvh result;
        run_host_build({mesh, mesh, mesh.triangles.size() - inactive}, algorithm, {}, scratch, result);
        return result;
    });
}

Bvh build_over_boxes(std::span<const Aabb> bounds, const BoundAlgorithm& algorithm) {
    return with_memory_errors("the build", [&] {
        Scratch scratch;
        Bvh result;
        build_over_boxes(bounds, algorithm, scratch, result);
        return result;
    });
}

void build_over_boxes(std::span<const Aabb> bounds, const BoundAlgorithm& algorithm, Scratch& scratch, Bvh& result) {
    check_primitive_count(bounds.size());
    check_boxes(bounds);
    scratch.reset();
    result.primitive_count = bounds.size();
    const ProgressCallback no_progress;
    HostStages stages(no_progress);
    const std::span<Reference> references = scratch.take<Reference>(bounds.size());
    const Bounds scene = copy_boxes(bounds, references);
    run_algorithm(references, scene, nullptr, algorithm, scratch, stages, result);
}

}  // namespace clbvh::host
