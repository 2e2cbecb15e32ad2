#include "host/build/host_build.hpp"

#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/simd/dispatch.hpp"
#include "host/build/primitive_bounds.hpp"

namespace clbvh::host {
namespace {

/// The build from references to the result; empty where there are none.
BuildStats run_algorithm(std::span<Reference> references, const Bounds& bounds, const MeshView* mesh,
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
    const Bounds bounds = bound_primitives(input.primitives, references, scratch);
    result.primitive_count = count_of(input.primitives);
    const MeshView* const mesh = input.cut ? &*input.cut : std::get_if<MeshView>(&input.primitives);
    BuildStats stats = run_algorithm(references, bounds, mesh, algorithm, scratch, stages, result);
    stats.inactive_primitives = result.primitive_count - input.active_count;
    return stats;
}

Bvh build_over(const Primitives& primitives, const BoundAlgorithm& algorithm) {
    return with_memory_errors("the build", [&] {
        Scratch scratch;
        Bvh result;
        build_over(primitives, algorithm, scratch, result);
        return result;
    });
}

void build_over(const Primitives& primitives, const BoundAlgorithm& algorithm, Scratch& scratch, Bvh& result) {
    const std::uint64_t inactive = check_primitives(primitives);
    in_own_group([&] {
        run_host_build({primitives, count_of(primitives) - inactive, {}}, algorithm, {}, scratch, result);
    });
}

}  // namespace clbvh::host
