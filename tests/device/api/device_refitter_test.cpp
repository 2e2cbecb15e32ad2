// Trees refitted in device memory: refit()'s boxes, bit for bit, and its costs, in both shapes.
#include "clbvh/device/device_refitter.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "clbvh/io/scene.hpp"
#include "clbvh/optimize/refit.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/compare_trees.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"
#include "support/refit_memory.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

cl_command_queue shared_queue() {
    return shared_context().opencl_queue();
}

Mesh twisted(Mesh mesh, float by) {
    for (Vec3& vertex : mesh.vertices)
        vertex = {vertex.x + by * std::sin(5.0f * vertex.y), vertex.y, -vertex.z};
    return mesh;
}

/// Refits `tree`, over `mesh`, to two frames in a row, in both shapes, beside the host.
void expect_refit(const Bvh& tree, const Mesh& mesh, const SahCosts& costs = {}) {
    const Mesh frames[] = {twisted(mesh, 0.3f), twisted(mesh, -2.0f)};
    for (const Shape shape : kBothShapes) {
        INFO(to_string(shape) << ", " << mesh.triangles.size() << " triangles");
        DeviceRefitter refitter = make_refitter(shape, costs);
        const RefitMemory memory(refitter, tree, mesh);
        refitter.enqueue_order(shared_queue(), memory.tree(), memory.order());
        refitter.enqueue_cost(shared_queue(), memory.tree(), memory.scratch(), memory.sah());
        const double quality = sah_cost(tree, costs);
        CHECK(memory.read_sah()[0] == Approx(quality).epsilon(1e-6));
        Bvh expected = tree;
        for (const Mesh& frame : frames) {
            const RefitStats stats = clbvh::refit(expected, frame, costs);
            memory.move(frame);
            refitter.enqueue(shared_queue(), memory.tree(), memory.refit());
            CHECK(same_bytes(memory.read_tree(), expected));
            expect_costs(memory.read_sah(), stats.sah_before, stats.sah_after);
        }
    }
}

}  // namespace

TEST_CASE("device refitter: trees of every builder, with leaves of one and of several primitives") {
    for (const char* const scene : {"city", "hair"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        for (const BuilderInfo& builder : builders()) {
            for (const std::uint32_t leaf_size : {0u, 8u}) {
                INFO(scene << ", " << builder.id << ", leaves of " << leaf_size);
                BuildOptions options;
                options.max_leaf_size = leaf_size;
                expect_refit(make_builder(builder.id, options).build(mesh), mesh);
            }
        }
        BuildOptions grouped;
        grouped.hploc.leaf_size = 4;
        expect_refit(make_builder("hploc", grouped).build(mesh), mesh);
    }
}

TEST_CASE("device refitter: costs are those that were asked for") {
    const Mesh mesh = generate_scene("clustered", 2000);
    expect_refit(make_builder("plocpp").build(mesh), mesh, {2.0, 0.5});
    expect_refit(make_builder("plocpp").build(mesh), mesh, {0.0, 3.0});
}

TEST_CASE("device refitter: larger trees, chains, slots without a node, and hardly any primitives") {
    const Mesh large = generate_scene("terrain", 60000);
    expect_refit(make_builder("lbvh").build(large), large);
    const Mesh mesh = random_triangles(5000);
    expect_refit(chain_tree(mesh), mesh);
    Bvh sparse = make_builder("binned-sah").build(mesh);
    sparse.nodes.resize(sparse.nodes.size() + 1001);
    expect_refit(sparse, mesh);
    for (const std::uint32_t count : {1u, 2u, 3u, 4u, 5u}) {
        const Mesh few = random_triangles(count);
        expect_refit(make_builder("plocpp").build(few), few);
    }
    const Mesh points = scaled(mesh, 0.0f);
    expect_refit(make_builder("plocpp").build(mesh), points);
}

TEST_CASE("device refitter: where the root has no area all nodes count as hit, before and after") {
    const Mesh line = line_of_points(3000);
    BuildOptions wide_leaves;
    wide_leaves.max_leaf_size = 8;
    for (const Bvh& tree : {make_builder("lbvh").build(line), make_builder("plocpp", wide_leaves).build(line)}) {
        for (const Shape shape : kBothShapes) {
            INFO(to_string(shape));
            DeviceRefitter refitter = make_refitter(shape);
            const RefitMemory memory(refitter, tree, line);
            refitter.enqueue_order(shared_queue(), memory.tree(), memory.order());
            double cost = sah_cost(tree);
            for (const Mesh& frame : flat_and_other_frames(line)) {
                refitter.enqueue_cost(shared_queue(), memory.tree(), memory.scratch(), memory.sah());
                CHECK(memory.read_sah()[0] == Approx(cost).epsilon(1e-6));
                const double before = cost;
                memory.move(frame);
                refitter.enqueue(shared_queue(), memory.tree(), memory.refit());
                cost = sah_cost(memory.read_tree());
                expect_costs(memory.read_sah(), before, cost);
            }
        }
    }
}

TEST_CASE("device refitter: primitives with a NaN count for nothing, and leaves with none but such are empty") {
    const Mesh mesh = random_triangles(300);
    BuildOptions options;
    options.max_leaf_size = 4;
    const Bvh tree = make_builder("plocpp", options).build(mesh);
    Mesh partly = mesh;
    deactivate_triangles(partly, 0, 2);
    Mesh without = mesh;
    deactivate_triangles(without);
    for (const Shape shape : kBothShapes) {
        DeviceRefitter refitter = make_refitter(shape);
        const RefitMemory memory(refitter, tree, mesh);
        refitter.enqueue_order(shared_queue(), memory.tree(), memory.order());
        memory.move(partly);
        refitter.enqueue(shared_queue(), memory.tree(), memory.refit());
        const Bvh fitted = memory.read_tree();
        Aabb all;
        for (std::size_t i = 1; i < mesh.triangles.size(); i += 2)
            all = merge(all, triangle_bounds(mesh, i));
        CHECK(fitted.nodes[0].bounds() == all);
        CHECK(same_topology(fitted, tree));
        for (const Node& node : fitted.nodes) {
            if (!node.is_leaf()) continue;
            Aabb box;
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                if (fitted.primitive_ids[i] % 2 == 1) box = merge(box, triangle_bounds(mesh, fitted.primitive_ids[i]));
            }
            CHECK(node.bounds() == box);
        }
        memory.move(without);
        refitter.enqueue(shared_queue(), memory.tree(), memory.refit());
        CHECK(memory.read_tree().nodes[0].bounds() == Aabb{});
        CHECK(memory.read_sah()[1] == 0.0f);
        memory.move(mesh);
        refitter.enqueue(shared_queue(), memory.tree(), memory.refit());
        CHECK(same_bytes(memory.read_tree(), tree));
    }
}
