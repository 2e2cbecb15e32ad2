#include "device/build/batch.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

std::string_view kernel_of(InputForm form) {
    switch (form) {
        case InputForm::indexed_16: return "batch_indexed_16";
        case InputForm::triangles: return "batch_triangles";
        case InputForm::boxes: return "batch_boxes";
        default: return "batch_indexed_32";
    }
}

struct BatchScratch {
    BatchScratch(std::uint64_t primitives, std::uint64_t trees, ArrayLayout layout)
        : leaves(layout.take_view(24 * primitives + 8 * trees)),
          inner(layout.take_view(32 * primitives)),
          references(layout.take_view(4 * primitives)),
          other(layout.take_view(4 * primitives)),
          bounds(layout.take_view(48 * trees)),
          bytes(layout.bytes()) {}

    cl::Buffer leaves, inner, references, other, bounds;
    std::uint64_t bytes;
};

}  // namespace

BatchPlan plan_batch(std::uint64_t primitives, std::uint64_t trees) {
    BatchPlan plan;
    plan.nodes = 64 * primitives;
    plan.primitive_ids = 4 * primitives;
    plan.active_counts = 4 * trees;
    plan.scratch = BatchScratch(primitives, trees, ArrayLayout()).bytes;
    return plan;
}

ProgramSpec batch_program(const BuildSettings& settings) {
    return {"batch.cl", settings.lane() ? 1 : std::min(kLargestBatchGroup, settings.cluster_group_size),
            settings.search_defines() + " -D MOST_CODE_BITS=" + std::to_string(settings.configs.device.code_bits) +
                " -D CUBIC_CELLS=" + (settings.configs.device.morton_code == MortonCode::cubic ? "1" : "0")};
}

void launch_batch(Launcher& launcher, const BuildSettings& settings, const BatchPlan& plan, const BatchJob& job) {
    const BatchScratch scratch(job.mesh.primitive_count, job.tree_count, ArrayLayout(job.scratch));
    launcher.launch(launcher.session().kernel(batch_program(settings), kernel_of(job.mesh.form)), job.tree_count,
                    job.mesh.vertices.buffer, job.mesh.vertices.offset, job.mesh.vertex_stride, job.mesh.index_buffer(),
                    job.mesh.indices.offset, job.mesh.index_stride, job.ranges.buffer, job.ranges.offset,
                    view_of(job.nodes, 0, plan.nodes), view_of(job.primitive_ids, 0, plan.primitive_ids),
                    view_of(job.active_counts, 0, plan.active_counts), scratch.leaves, scratch.inner,
                    scratch.references, scratch.other, scratch.bounds);
    // At least: the input's corners and indices are read; boxes are written, read twice and written again as leaves;
    // keys, references and ids are written; a merge reads two records and writes one and a sibling pair.
    launcher.count_bytes((48 + 4 * 24 + 8 + 8 + 2 * 32 + 32 + 64) * std::uint64_t{job.mesh.primitive_count});
}

}  // namespace clbvh::device
