// Treelets on the device beside the host's, which were proven to be the best trees over their leaves.
#include "clbvh/optimize/treelet.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "clbvh/device/device_optimizer.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "optimize/edit_tree.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

DeviceOptimizer make_treelets(Shape shape, std::uint32_t passes = 0) {
    DeviceOptimizerOptions options;
    options.shape = shape;
    options.passes = passes;
    return {"treelet", shared_context(), options};
}

Bvh on_host(const Bvh& tree, std::uint32_t passes = 0) {
    TreeletConfig config;
    config.budget.passes = passes;
    return restructure_treelets(tree, config);
}

/// Exact to double precision.
double inner_area(Bvh tree) {
    return optimizer::EditTree(tree.nodes).inner_half_area();
}

}  // namespace

TEST_CASE("device treelets: as good as the host's") {
    DeviceOptimizer lane = make_treelets(Shape::lane);
    DeviceOptimizer group = make_treelets(Shape::group);
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 8000);
        for (const char* const builder : {"lbvh", "plocpp", "binned-sah"}) {
            INFO(scene.name << ", " << builder);
            const Bvh tree = make_builder(builder).build(mesh);
            const Bvh better = lane.optimize(tree);
            CHECK(sah_cost(better) == Approx(sah_cost(on_host(tree))).epsilon(0.002));
            CHECK(same_bytes(better, group.optimize(tree)));
            CHECK(inner_area(better) <= inner_area(tree));
        }
    }
}

TEST_CASE("device treelets: a tree of seven leaves becomes the best there is") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        DeviceOptimizer treelets = make_treelets(shape);
        for (std::uint32_t seed = 1; seed <= 20; ++seed) {
            const Bvh tree = make_builder("lbvh").build(mesh_of_boxes(random_boxes(7, seed)));
            CHECK(inner_area(treelets.optimize(tree)) == Approx(inner_area(on_host(tree))).epsilon(1e-5));
        }
    }
}

TEST_CASE("device treelets: each pass improves what the one before has left") {
    const Bvh tree = make_builder("lbvh").build(generate_scene("clustered", 30000));
    double before = sah_cost(tree);
    for (const std::uint32_t passes : {1u, 2u, 3u, 6u}) {
        INFO(passes);
        const Bvh better = make_treelets(Shape::lane, passes).optimize(tree);
        CHECK(sah_cost(better) < before);
        CHECK(sah_cost(better) == Approx(sah_cost(on_host(tree, passes))).epsilon(0.002));
        before = sah_cost(better);
    }
    // Beyond the size of the tree there is nothing to do.
    CHECK(same_bytes(make_treelets(Shape::lane, 40).optimize(tree), make_treelets(Shape::lane, 1000).optimize(tree)));
}

TEST_CASE("device treelets: of other sizes they are as good as the host's, and larger ones better") {
    const Bvh tree = make_builder("lbvh").build(generate_scene("clustered", 10000));
    double before = sah_cost(tree);
    for (const std::uint32_t leaves : {3u, 5u, 8u}) {
        INFO(leaves);
        DeviceOptimizerOptions options;
        options.treelet_leaves = leaves;
        options.shape = Shape::lane;
        const Bvh better = DeviceOptimizer("treelet", shared_context(), options).optimize(tree);
        options.shape = Shape::group;
        CHECK(same_bytes(DeviceOptimizer("treelet", shared_context(), options).optimize(tree), better));
        TreeletConfig config;
        config.leaves = leaves;
        config.least_size = std::max(leaves, config.least_size);
        CHECK(sah_cost(better) == Approx(sah_cost(restructure_treelets(tree, config))).epsilon(0.001));
        CHECK(sah_cost(better) < before);
        before = sah_cost(better);
    }
    for (const std::uint32_t leaves : {2u, 9u}) {
        DeviceOptimizerOptions options;
        options.treelet_leaves = leaves;
        expect_error(ErrorCode::invalid_input, {"treelet_leaves"},
                     [&] { DeviceOptimizer("treelet", shared_context(), options); });
    }
}

TEST_CASE("device treelets: a tree that cannot be improved keeps its bytes") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        DeviceOptimizer treelets = make_treelets(shape, 20);
        Bvh tree = make_builder("lbvh").build(generate_scene("soup", 3000));
        for (int round = 0; round < 20; ++round)
            tree = make_treelets(shape, 1).optimize(tree);
        CHECK(inner_area(treelets.optimize(tree)) <= inner_area(tree));
        const Bvh equal = make_builder("lbvh").build(coincident_triangles(3000));
        CHECK(same_bytes(treelets.optimize(equal), equal));
    }
}
