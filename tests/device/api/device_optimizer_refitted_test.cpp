// Optimisers on trees that were refitted on the device to triangles some of which became inactive: the leaves of these
// have empty boxes, which cost nothing.
#include <catch2/catch.hpp>

#include "clbvh/catalog.hpp"
#include "clbvh/device/device_optimizer.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/compare_trees.hpp"
#include "support/meshes.hpp"
#include "support/refit_memory.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// The first even slot from `begin` on where two leaves stand.
std::uint32_t leaf_pair(const Bvh& tree, std::uint32_t begin) {
    for (std::uint32_t slot = begin; slot + 1 < tree.nodes.size(); slot += 2) {
        if (tree.nodes[slot].is_leaf() && tree.nodes[slot + 1].is_leaf()) return slot;
    }
    return 0;
}

void deactivate_below(Mesh& mesh, const Bvh& tree, std::uint32_t slot) {
    const Node& node = tree.nodes[slot];
    if (!node.is_leaf()) {
        deactivate_below(mesh, tree, node.first);
        deactivate_below(mesh, tree, node.first + 1);
        return;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        deactivate_triangles(mesh, tree.primitive_ids[i], mesh.triangles.size());
}

/// What becomes of `tree`, over `mesh`, refitted to `moved` and optimised in one shape; its cost must not rise.
Bvh optimize_refitted(std::string_view id, Shape shape, const Bvh& tree, const Mesh& mesh, const Mesh& moved) {
    const cl_command_queue queue = shared_context().opencl_queue();
    DeviceRefitter refitter = make_refitter(shape);
    DeviceOptimizerOptions options;
    options.shape = shape;
    DeviceOptimizer optimizer(id, shared_context(), options);
    const RefitMemory memory(refitter, tree, mesh);
    const cl::Buffer scratch = filled_buffer(optimizer.scratch_bytes(memory.tree().node_count));
    refitter.enqueue_order(queue, memory.tree(), memory.order());
    memory.move(moved);
    refitter.enqueue(queue, memory.tree(), memory.refit());
    refitter.enqueue_cost(queue, memory.tree(), memory.scratch(), memory.sah());
    const float before = memory.read_sah()[0];
    optimizer.enqueue(queue, memory.tree(), {scratch()});
    refitter.enqueue_cost(queue, memory.tree(), memory.scratch(), memory.sah());
    const float after = memory.read_sah()[0];
    CHECK(before > 0.0f);
    CHECK(after <= before * (1.0f + 1e-6f));
    return memory.read_tree();
}

}  // namespace

TEST_CASE("device optimizers: leaves that a refit left empty are free, and costs do not rise for them") {
    const Mesh mesh = random_triangles(2000);
    const Bvh tree = make_builder("lbvh").build(mesh);
    std::vector<Mesh> frames(4, mesh);
    deactivate_below(frames[0], tree, leaf_pair(tree, 2));
    deactivate_below(frames[0], tree, leaf_pair(tree, 2) + 1);
    for (std::uint32_t slot = leaf_pair(tree, 100); slot != 0; slot = leaf_pair(tree, slot + 20)) {
        deactivate_below(frames[1], tree, slot);
        deactivate_below(frames[1], tree, slot + 1);
    }
    deactivate_below(frames[2], tree, tree.nodes[0].first);
    deactivate_triangles(frames[3], 0, 3);
    for (const OptimizerInfo& info : optimizers()) {
        if (!info.on_device) continue;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            INFO(info.id << ", frame " << i);
            const Bvh in_groups = optimize_refitted(info.id, Shape::group, tree, mesh, frames[i]);
            const Bvh in_lanes = optimize_refitted(info.id, Shape::lane, tree, mesh, frames[i]);
            CHECK(same_bytes(in_groups, in_lanes));
        }
    }
}
