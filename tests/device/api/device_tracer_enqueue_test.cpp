// Rays on the caller's queue, in the caller's memory: the host tracer's hits and counts, wherever the tree and its
// triangles are, with nothing allocated and nothing waited for.
#include <catch2/catch.hpp>

#include "clbvh/device/device_tracer.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/device_rays.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/found_rays.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

DeviceScene scene_of(const DeviceTree& tree) {
    const auto& triangles = std::get<DeviceTriangles>(tree.input());
    return {DeviceBvh::of(tree.result(), triangles.count), triangles, {}};
}

std::vector<InputLayout> triangle_layouts() {
    std::vector<InputLayout> layouts;
    for (const InputLayout& layout : input_layouts()) {
        if (layout.kind != InputLayout::Kind::boxes) layouts.push_back(layout);
    }
    return layouts;
}

cl_command_queue shared_queue() {
    return shared_context().opencl_queue();
}

}  // namespace

TEST_CASE("device tracer: triangles in any form, and in a traversal layout") {
    Mesh mesh = random_triangles(3000);
    const std::vector<Ray> rays = rays_for(mesh);
    deactivate_triangles(mesh, 0, 7);
    DeviceBuilder builder("hploc", shared_context());
    for (const InputLayout& layout : triangle_layouts()) {
        DeviceTree tree(builder, layout, mesh);
        tree.enqueue();
        for_each_tracer([&](DeviceTracer& tracer) {
            INFO(layout.name);
            const Found expected = found_by_host(tree.read(), mesh, tracer.options().triangle_test, rays);
            DeviceScene scene = scene_of(tree);
            const DeviceRayMemory memory(tracer, scene.bvh, rays);
            for (const bool is_copied : {false, true}) {
                if (is_copied) {
                    scene.layout = memory.layout();
                    tracer.enqueue_layout(shared_queue(), scene);
                    scene.triangles = {};
                }
                Found found(rays.size());
                tracer.enqueue_closest(shared_queue(), scene, memory.rays());
                found.hits = memory.hits();
                found.closest_counts = memory.counts();
                tracer.enqueue_any(shared_queue(), scene, memory.rays());
                found.is_hit = memory.bytes();
                found.any_counts = memory.counts();
                check_same(found, expected);
                DeviceRays uncounted = memory.rays();
                uncounted.counts = {};
                tracer.enqueue_closest(shared_queue(), scene, uncounted);
                found.hits = memory.hits();
                tracer.enqueue_any(shared_queue(), scene, uncounted);
                found.is_hit = memory.bytes();
                check_same(found, expected);
            }
            CHECK(memory.guards_are_whole());
        });
    }
}

TEST_CASE("device tracer: a build, a layout and rays follow each other on any queue, and nobody waits") {
    const Mesh mesh = random_triangles(2000);
    const std::vector<Ray> rays = rays_for(mesh);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTracer tracer(shared_context());
    for (const cl::CommandQueue& queue : {shared_context().session().queue(), out_of_order_queue()}) {
        if (queue() == nullptr) {
            WARN("SKIPPED: the device has no queues out of order");
            continue;
        }
        DeviceTree tree(builder, input_layouts().front(), mesh);
        tree.clear_input();
        DeviceScene scene = scene_of(tree);
        const DeviceRayMemory memory(tracer, scene.bvh, rays);
        scene.layout = memory.layout();
        cl::UserEvent written(shared_context().session().context());
        cl_event laid_out = nullptr, traced = nullptr;
        const cl::Event built = tree.enqueue(queue, {written()});
        cl_event built_event = built();
        tracer.enqueue_layout(queue(), scene, {&built_event, 1}, &laid_out);
        tracer.enqueue_closest(queue(), scene, memory.rays(), {&laid_out, 1}, &traced);
        const cl::Event layout(laid_out), end(traced);
        queue.flush();
        CHECK(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
        tree.write_input(own_queue());
        written.setStatus(CL_COMPLETE);
        end.wait();
        Found expected = found_by_host(tree.read(), mesh, TriangleTest::watertight, rays), found = expected;
        found.hits = memory.hits();
        found.closest_counts = memory.counts();
        check_same(found, expected);
    }
}

TEST_CASE("device tracer: enqueuing allocates nothing, builds nothing and waits for nothing") {
    const Mesh mesh = random_triangles(2000);
    const std::vector<Ray> rays = rays_for(mesh);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), mesh);
    for_each_tracer([&](DeviceTracer& tracer) {
        DeviceScene scene = scene_of(tree);
        const DeviceRayMemory memory(tracer, scene.bvh, rays);
        scene.layout = memory.layout();
        const OpenClCalls calls = opencl_calls_of([&] {
            tree.enqueue_only();
            tracer.enqueue_layout(shared_queue(), scene);
            tracer.enqueue_closest(shared_queue(), scene, memory.rays());
            tracer.enqueue_any(shared_queue(), scene, memory.rays());
        });
        CHECK(calls.launches > 7);
        CHECK(calls.buffers == 0);
        CHECK(calls.programs == 0);
        CHECK(calls.waits == 0);
        shared_context().session().queue().finish();
    });
}

TEST_CASE("device tracer: every ray misses where no primitive is active, and where there is no tree") {
    Mesh mesh = random_triangles(100);
    const std::vector<Ray> rays = rays_for(mesh, 10);
    deactivate_triangles(mesh);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), mesh);
    tree.enqueue();
    for_each_tracer([&](DeviceTracer& tracer) {
        const Found nothing(rays.size());
        const DeviceRayMemory memory(tracer, scene_of(tree).bvh, rays);
        DeviceScene laid_out = scene_of(tree);
        laid_out.layout = memory.layout();
        tracer.enqueue_layout(shared_queue(), laid_out);
        tracer.enqueue_layout(shared_queue(), DeviceScene{});
        DeviceScene unnamed = laid_out;  // nodes, and none of the references that leaves would need
        unnamed.bvh.reference_count = 0;
        tracer.enqueue_layout(shared_queue(), unnamed);
        for (const DeviceScene& scene : {scene_of(tree), laid_out, unnamed, DeviceScene{}}) {
            tracer.enqueue_closest(shared_queue(), scene, memory.rays());
            CHECK(count_differences(memory.hits(), nothing.hits) == 0);
            CHECK(count_differences(memory.counts(), nothing.closest_counts) == 0);
            tracer.enqueue_any(shared_queue(), scene, memory.rays());
            CHECK(count_differences(memory.bytes(), nothing.is_hit) == 0);
            DeviceRays uncounted = memory.rays();
            uncounted.counts = {};
            tracer.enqueue_closest(shared_queue(), scene, uncounted);
            CHECK(count_differences(memory.hits(), nothing.hits) == 0);
            CHECK(memory.guards_are_whole());
        }
        Bvh empty;
        empty.primitive_count = mesh.triangles.size();
        tracer.set_scene(empty, mesh);
        check_same(found_by_device(tracer, rays), nothing);
    });
}

TEST_CASE("device tracer: no rays, and counts that are left out") {
    const Mesh mesh = random_triangles(100);
    const std::vector<Ray> rays = rays_for(mesh, 10);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), mesh);
    tree.enqueue();
    DeviceTracer tracer(shared_context());
    const DeviceScene scene = scene_of(tree);
    const DeviceRayMemory memory(tracer, scene.bvh, rays);
    DeviceRays some = memory.rays();
    some.counts = {};
    const std::vector<RayCounts> before = memory.counts();
    tracer.enqueue_closest(shared_queue(), scene, some);
    CHECK(count_differences(memory.counts(), before) == 0);
    const std::vector<Hit> hits = memory.hits();
    cl_event event = nullptr;
    tracer.enqueue_closest(shared_queue(), scene, {}, {}, &event);
    const cl::Event end(event);
    end.wait();
    CHECK(count_differences(memory.hits(), hits) == 0);

    tracer.set_scene(tree.read(), mesh);
    std::vector<Hit> again(rays.size());
    tracer.closest(rays, again);
    CHECK(count_differences(again, hits) == 0);
    tracer.closest({}, {});
    tracer.any({}, {});
}

TEST_CASE("device tracer: what is wrong with memory of the caller's is named, and nothing is enqueued") {
    const Mesh mesh = random_triangles(100);
    const std::vector<Ray> many(100);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), mesh);
    tree.enqueue();
    DeviceTracer tracer(shared_context());
    const DeviceRayMemory memory(tracer, scene_of(tree).bvh, many);
    const cl::CommandQueue& queue = shared_context().session().queue();
    const cl::Context other_context(queue.getInfo<CL_QUEUE_DEVICE>());
    const cl::CommandQueue foreign_queue(other_context, queue.getInfo<CL_QUEUE_DEVICE>());
    const cl::Buffer read_only(shared_context().session().context(), CL_MEM_READ_ONLY, 1 << 20);

    struct Arguments {
        cl_command_queue queue;
        DeviceScene scene;
        DeviceRays rays;
        std::vector<cl_event> wait_list;
    };
    const Arguments sound{queue(), scene_of(tree), memory.rays(), {}};
    const auto expect_refused = [&](std::initializer_list<std::string> words, auto&& change) {
        Arguments a = sound;
        change(a);
        const OpenClCalls calls = opencl_calls_of([&] {
            expect_error(ErrorCode::invalid_input, words,
                         [&] { tracer.enqueue_closest(a.queue, a.scene, a.rays, a.wait_list); });
        });
        CHECK(calls.launches == 0);
    };
    expect_refused({"queue is null"}, [](Arguments& a) { a.queue = nullptr; });
    expect_refused({"queue", "another OpenCL context"}, [&](Arguments& a) { a.queue = foreign_queue(); });
    expect_refused({"wait list", "null"}, [](Arguments& a) { a.wait_list = {nullptr}; });
    expect_refused({"the nodes", "no buffer"}, [](Arguments& a) { a.scene.bvh.nodes = {}; });
    expect_refused({"the nodes", "needs", "bytes"}, [](Arguments& a) { a.scene.bvh.node_count = 1000000; });
    expect_refused({"the nodes", "multiple of 64"}, [](Arguments& a) { a.scene.bvh.nodes.offset += 32; });
    expect_refused({"the primitive ids' offset"}, [](Arguments& a) { a.scene.bvh.primitive_ids.offset += 2; });
    expect_refused({"the vertices", "no buffer"}, [](Arguments& a) { a.scene.triangles.vertices = {}; });
    expect_refused({"the vertices' stride is 8"}, [](Arguments& a) { a.scene.triangles.vertex_stride = 8; });
    expect_refused({"the layout", "needs", "bytes"}, [&](Arguments& a) {
        a.scene.layout = {read_only(), (1 << 20) - 64};
    });
    static const cl::Buffer write_only(shared_context().session().context(), CL_MEM_WRITE_ONLY, 1 << 20);
    expect_refused({"the nodes", "CL_MEM_WRITE_ONLY"}, [](Arguments& a) { a.scene.bvh.nodes = {write_only()}; });
    expect_refused({"the primitive ids", "CL_MEM_WRITE_ONLY"},
                   [](Arguments& a) { a.scene.bvh.primitive_ids = {write_only()}; });
    expect_refused({"the layout", "CL_MEM_WRITE_ONLY"}, [](Arguments& a) { a.scene.layout = {write_only()}; });
    expect_refused({"the rays", "CL_MEM_WRITE_ONLY"}, [](Arguments& a) { a.rays.rays = {write_only()}; });
    expect_refused({"the rays", "no buffer"}, [](Arguments& a) { a.rays.rays = {}; });
    expect_refused({"the rays", "needs 3232 bytes"}, [](Arguments& a) { a.rays.count = 101; });
    expect_refused({"the rays", "multiple of 16"}, [](Arguments& a) {
        a.rays.count = 1;
        a.rays.rays.offset = 8;
    });
    expect_refused({"the results", "multiple of 16"}, [](Arguments& a) { a.rays.results.offset += 4; });
    expect_refused({"the results", "CL_MEM_READ_WRITE"}, [&](Arguments& a) { a.rays.results = {read_only()}; });
    expect_refused({"the counts", "multiple of 16"}, [](Arguments& a) { a.rays.counts.offset += 4; });
    expect_refused({"the scratch", "no buffer"}, [](Arguments& a) { a.rays.scratch = {}; });
    expect_refused({"the results and the rays overlap"}, [](Arguments& a) {
        a.rays.count = 2;
        a.rays.rays = a.rays.results;
    });
    expect_refused({"the results and the nodes overlap"}, [](Arguments& a) {
        a.rays.count = 1;
        a.rays.results = a.scene.bvh.nodes;
    });
    Arguments layout = sound;
    const cl::Buffer large(shared_context().session().context(), CL_MEM_READ_WRITE, 1 << 20);
    layout.scene.layout = {large(), 8};
    expect_error(ErrorCode::invalid_input, {"the layout", "multiple of 64"},
                 [&] { tracer.enqueue_layout(layout.queue, layout.scene); });
    layout.scene.layout = {read_only()};
    expect_error(ErrorCode::invalid_input, {"the layout", "CL_MEM_READ_WRITE"},
                 [&] { tracer.enqueue_layout(layout.queue, layout.scene); });
    DeviceRays too_many = sound.rays;
    too_many.count = kMaxDeviceRays + 1;
    expect_error(ErrorCode::unsupported, {"2147483648 rays", "2147483647"},
                 [&] { tracer.enqueue_any(sound.queue, sound.scene, too_many); });
    tracer.enqueue_closest(sound.queue, sound.scene, sound.rays);
    queue.finish();
}
