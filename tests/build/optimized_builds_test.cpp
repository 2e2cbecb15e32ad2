// Optimisers behind a build on the device: the tree that the optimisers alone make of the builder's, in memory that the
// two share, without a wait.
#include <catch2/catch.hpp>

#include "clbvh/catalog.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/device/batch_builder.hpp"
#include "clbvh/device/device_optimizer.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Ids of those that run on devices, with commas between them.
std::string device_optimizers() {
    std::string ids;
    for (const OptimizerInfo& info : optimizers()) {
        if (!info.on_device) continue;
        if (!ids.empty()) ids += ',';
        ids += info.id;
    }
    return ids;
}

BuildOptions optimizing(Shape shape) {
    BuildOptions options = options_of(shape);
    options.optimizers = device_optimizers();
    options.optimize_on = OptimizeOn::device;
    return options;
}

/// The builder's tree as a DeviceOptimizer improves it.
Bvh optimized_apart(std::string_view id, Shape shape, const Mesh& mesh) {
    DeviceOptimizerOptions options;
    options.shape = shape;
    DeviceOptimizer optimizer(device_optimizers(), shared_context(), options);
    return optimizer.optimize(make_builder(id, options_of(shape)).build(mesh));
}

Mesh mesh_with_holes(std::uint32_t triangles) {
    Mesh mesh = random_triangles(triangles);
    deactivate_triangles(mesh, 0, 7);
    return mesh;
}

}  // namespace

TEST_CASE("optimized builds: the tree is the one that the optimizers make of the builder's") {
    const Mesh mesh = mesh_with_holes(6000);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : enqueued_builders()) {
            INFO(id << ", " << to_string(shape));
            const Bvh expected = optimized_apart(id, shape, mesh);
            CHECK(validate(expected, mesh).error == "");
            BuildStats stats;
            Builder builder = make_builder(id, optimizing(shape));
            CHECK(same_bytes(builder.build(mesh, &stats), expected));
            CHECK(stage(stats, "treelet").launches > 0);
            CHECK(stats.stages.back().name != "download");
            DeviceBuilder on_queue(id, shared_context(), optimizing(shape));
            for (const Placement placement : {Placement::own_buffers, Placement::parts_of_one_buffer}) {
                DeviceTree tree(on_queue, input_layouts().front(), mesh, placement);
                tree.enqueue();
                CHECK(same_bytes(tree.read(), expected));
                CHECK(tree.guards_are_whole());
            }
        }
    }
}

TEST_CASE("optimized builds: meshes of any size, also where all primitives are inactive") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        DeviceBuilder builder("lbvh", shared_context(), optimizing(shape));
        for (const std::uint32_t size : {1u, 2u, 3u, 4u, 100u}) {
            INFO(size << ", " << to_string(shape));
            Mesh mesh = random_triangles(size);
            DeviceTree tree(builder, input_layouts().front(), mesh);
            tree.enqueue();
            CHECK(same_bytes(tree.read(), optimized_apart("lbvh", shape, mesh)));
            deactivate_triangles(mesh);
            DeviceTree none(builder, input_layouts().front(), mesh);
            none.enqueue();
            CHECK(none.read().empty());
            CHECK(none.root().lower[0] > none.root().upper[0]);
            CHECK(none.guards_are_whole());
            CHECK(make_builder("lbvh", optimizing(shape)).build(mesh).empty());
        }
        CHECK(make_builder("lbvh", optimizing(shape)).build(Mesh{}).empty());
        CHECK(builder.sizes(0).scratch == 0);
    }
}

TEST_CASE("optimized builds: nothing is allocated, built or waited for, and scratch is shared") {
    const Mesh mesh = random_triangles(30000);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        DeviceBuilder plain("hploc", shared_context(), options_of(shape));
        DeviceBuilder builder("hploc", shared_context(), optimizing(shape));
        DeviceOptimizer optimizer(device_optimizers(), shared_context());
        CHECK(builder.sizes(30000).nodes == plain.sizes(30000).nodes);
        CHECK(builder.sizes(30000).scratch < plain.sizes(30000).scratch + optimizer.scratch_bytes(60000));
        DeviceTree tree(builder, input_layouts().front(), mesh);
        const OpenClCalls calls = opencl_calls_of([&] { tree.enqueue_only(); });
        CHECK(calls.launches > 0);
        CHECK(calls.buffers == 0);
        CHECK(calls.programs == 0);
        CHECK(calls.waits == 0);
        shared_context().session().queue().finish();
        CHECK(tree.guards_are_whole());
        Builder again = make_builder("hploc", optimizing(shape));
        again.upload(mesh);
        (void)again.run();
        const OpenClCalls later = opencl_calls_of([&] { (void)again.run(); });
        CHECK(later.buffers == 0);
        CHECK(later.programs == 0);
    }
}

TEST_CASE("optimized builds: a tree on the caller's queue can be optimized behind its build, inactive primitives too") {
    const Mesh mesh = mesh_with_holes(5000);
    const cl::CommandQueue queue = out_of_order_queue();
    if (queue() == nullptr) {
        WARN("SKIPPED: the device has no queues out of order");
        return;
    }
    for (const Shape shape : {Shape::group, Shape::lane}) {
        DeviceBuilder builder("plocpp", shared_context(), options_of(shape));
        DeviceTree tree(builder, input_layouts().front(), mesh);
        DeviceOptimizerOptions options;
        options.shape = shape;
        DeviceOptimizer optimizer(device_optimizers(), shared_context(), options);
        const cl::Buffer scratch(shared_context().session().context(), CL_MEM_READ_WRITE,
                                 optimizer.scratch_bytes(10000));
        const cl::Event built = tree.enqueue(queue);
        const std::vector<cl_event> wait_list{built()};
        optimizer.enqueue(queue(), DeviceBvh::of(tree.result(), 5000), {scratch()}, wait_list);
        queue.finish();
        CHECK(same_bytes(tree.read(), optimized_apart("plocpp", shape, mesh)));
        CHECK(tree.guards_are_whole());
    }
}

TEST_CASE("optimized builds: leaves are merged behind it, and a build can be cancelled in it") {
    const Mesh mesh = generate_scene("city", 10000);
    BuildOptions options;
    options.max_leaf_size = 4;
    const double plain = sah_cost(make_builder("lbvh", options).build(mesh));
    options.optimizers = "treelet";
    const double on_host = sah_cost(make_builder("lbvh", options).build(mesh));
    options.optimize_on = OptimizeOn::device;
    BuildStats stats;
    const Bvh tree = make_builder("lbvh", options).build(mesh, &stats);
    CHECK(validate(tree, mesh).error == "");
    CHECK(sah_cost(tree) < plain);
    CHECK(sah_cost(tree) == Approx(on_host).epsilon(0.005));
    CHECK(stage(stats, "collapse").host_ms > 0.0);
    options.presplit_level = 10;
    CHECK(validate(make_builder("lbvh", options).build(mesh), mesh).error == "");
    options.presplit_level = 0;
    bool cancels = true;
    options.progress = [&](const Progress& progress) { return progress.stage != "treelet" || !cancels; };
    Builder builder = make_builder("lbvh", options);
    expect_error(ErrorCode::cancelled, {"treelet"}, [&] { static_cast<void>(builder.build(mesh)); });
    cancels = false;
    CHECK(same_bytes(builder.build(mesh), tree));
}

TEST_CASE("optimized builds: what cannot run on the device is refused by name") {
    BuildOptions options;
    options.optimizers = "treelet,rotate";
    expect_error(ErrorCode::unsupported, {"rotate", "host"}, [&] { DeviceBuilder("lbvh", shared_context(), options); });
    options.optimize_on = OptimizeOn::device;
    expect_error(ErrorCode::unsupported, {"rotate", "host"}, [&] { static_cast<void>(make_builder("lbvh", options)); });
    options.optimizers = "treelet";
    expect_error(ErrorCode::unsupported, {"optimize_on", "sweep-sah"},
                 [&] { static_cast<void>(make_builder("sweep-sah", options)); });
    expect_error(ErrorCode::unsupported, {"optimizers", "BatchBuilder"},
                 [&] { BatchBuilder(shared_context(), options); });
    options.optimizers = "";
    CHECK(make_builder("sweep-sah", options).build(random_triangles(10)).nodes.size() > 2);
}
