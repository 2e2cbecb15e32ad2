// Rays on the device: the host tracer's hits and counts, bit for bit, whatever the tree and wherever its memory is.
#include "clbvh/device/device_tracer.hpp"

#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstddef>
#include <limits>

#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "device/session.hpp"
#include "support/builders.hpp"
#include "support/device_rays.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"
#include "support/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

DeviceTracerOptions tracer_options(Shape shape, TriangleTest test = TriangleTest::watertight) {
    DeviceTracerOptions options;
    options.shape = shape;
    options.triangle_test = test;
    return options;
}

/// Calls `check` with a tracer of each shape and test.
template <typename Check>
void for_each_tracer(Check check) {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
            INFO(to_string(shape) << ", test " << static_cast<int>(test));
            DeviceTracer tracer(shared_context(), tracer_options(shape, test));
            check(tracer);
        }
    }
}

/// What rays find, and what it costs.
struct Found {
    std::vector<Hit> hits;
    std::vector<std::uint8_t> is_hit;
    std::vector<RayCounts> closest_counts, any_counts;

    explicit Found(std::size_t rays) : hits(rays), is_hit(rays), closest_counts(rays), any_counts(rays) {}
};

Found found_by_host(const Bvh& bvh, const Mesh& mesh, TriangleTest test, std::span<const Ray> rays) {
    const Tracer tracer(bvh, mesh, {test});
    Found found(rays.size());
    tracer.closest(rays, found.hits, found.closest_counts);
    tracer.any(rays, found.is_hit, found.any_counts);
    return found;
}

template <typename T>
std::size_t count_differences(const std::vector<T>& a, const std::vector<T>& b) {
    std::size_t differences = a.size() == b.size() ? 0 : 1;
    const auto bits = [](const T& value) { return std::bit_cast<std::array<std::byte, sizeof(T)>>(value); };
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        differences += bits(a[i]) != bits(b[i]) ? 1 : 0;
    return differences;
}

/// Also checks that nothing changes where nobody counts.
Found found_by_device(DeviceTracer& tracer, std::span<const Ray> rays) {
    Found found(rays.size()), uncounted(rays.size());
    tracer.closest(rays, found.hits, found.closest_counts);
    tracer.any(rays, found.is_hit, found.any_counts);
    tracer.closest(rays, uncounted.hits);
    tracer.any(rays, uncounted.is_hit);
    if (!tracer.is_exact()) return found;
    CHECK(count_differences(uncounted.hits, found.hits) == 0);
    CHECK(count_differences(uncounted.is_hit, found.is_hit) == 0);
    return found;
}

std::size_t count_other_primitives(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    std::size_t differences = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        differences += a[i].primitive != b[i].primitive ? 1 : 0;
    return differences;
}

/// Bit for bit where the device can do that, else but for the rays that run along edges.
void check_same(const Found& found, const Found& expected) {
    if (!DeviceTracer(shared_context()).is_exact()) {
        WARN("SKIPPED: the device does not round as the host does, so bits go unchecked");
        CHECK(count_other_primitives(found.hits, expected.hits) <= expected.hits.size() / 10);
        return;
    }
    CHECK(count_differences(found.hits, expected.hits) == 0);
    CHECK(count_differences(found.is_hit, expected.is_hit) == 0);
    CHECK(count_differences(found.closest_counts, expected.closest_counts) == 0);
    CHECK(count_differences(found.any_counts, expected.any_counts) == 0);
}

std::vector<Ray> rays_for(const Mesh& mesh, std::size_t each = 100) {
    std::vector<Ray> rays = difficult_rays(mesh, each);
    const std::vector<Ray> untraceable = untraceable_rays();
    rays.insert(rays.end(), untraceable.begin(), untraceable.end());
    return rays;
}

/// A tree over big triangles at z = 0, 1, 2, ..., `each` of them at every z: a leaf beside all that are above it. A ray
/// downwards keeps a leaf for later at every level; beyond x + y = 1 it visits all of them and hits none.
struct Chain {
    Mesh mesh;
    Bvh bvh;

    explicit Chain(std::uint32_t length, std::uint32_t each = 1) {
        bvh.primitive_count = std::uint64_t{length} * each;
        const auto box_from = [&](std::uint32_t begin, std::uint32_t end, std::uint32_t first, std::uint32_t count) {
            return Node{{0, 0, static_cast<float>(begin)}, first, {1, 1, static_cast<float>(end)}, count};
        };
        const std::uint32_t last = length - 1;
        bvh.nodes = {box_from(0, last, 2, 0), Node{}};
        for (std::uint32_t i = 0; i < length; ++i) {
            const auto z = static_cast<float>(i);
            mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
            for (std::uint32_t k = 0; k < each; ++k) {
                bvh.primitive_ids.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
                mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
            }
            if (i == last) break;
            bvh.nodes.push_back(box_from(i, i, i * each, each));
            const bool is_end = i + 2 == length;
            bvh.nodes.push_back(is_end ? box_from(last, last, last * each, each) : box_from(i + 1, last, 2 * i + 4, 0));
        }
    }

    [[nodiscard]] static std::vector<Ray> rays(std::uint32_t count) {
        std::vector<Ray> rays;
        for (std::uint32_t i = 0; i < count; ++i) {
            Ray ray;
            const float xy = static_cast<float>(i + 1) / static_cast<float>(count + 2);
            ray.origin = {xy, xy, i % 3 == 0 ? -1.0f : 1e6f};
            ray.direction = {0, 0, i % 3 == 0 ? 1.0f : -1.0f};
            rays.push_back(ray);
        }
        return rays;
    }
};

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

TEST_CASE("device tracer: hits and counts are the host tracer's, for every generated scene") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 2000);
        const std::vector<Ray> rays = rays_for(mesh);
        const Bvh bvh = build(mesh, "locally-ordered");
        for_each_tracer([&](DeviceTracer& tracer) {
            INFO(scene.name);
            tracer.set_scene(bvh, mesh);
            check_same(found_by_device(tracer, rays), found_by_host(bvh, mesh, tracer.options().triangle_test, rays));
        });
    }
}

TEST_CASE("device tracer: trees with leaves of several triangles, with split ones, and of one leaf") {
    const Mesh mesh = generate_scene("city", 3000);
    const std::vector<Ray> rays = rays_for(mesh);
    BuildOptions collapsed;
    collapsed.max_leaf_size = 8;
    Bvh one_leaf;
    one_leaf.primitive_count = mesh.triangles.size();
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
        one_leaf.primitive_ids.push_back(i);
    Node root = build(mesh, "median").nodes[0];
    root.first = 0;
    root.count = static_cast<std::uint32_t>(mesh.triangles.size());
    one_leaf.nodes = {root, Node{}};
    for (const Bvh& bvh : {build(mesh, "binned-sah", collapsed), build(mesh, "sbvh"), one_leaf}) {
        for_each_tracer([&](DeviceTracer& tracer) {
            tracer.set_scene(bvh, mesh);
            check_same(found_by_device(tracer, rays), found_by_host(bvh, mesh, tracer.options().triangle_test, rays));
        });
    }
}

TEST_CASE("device tracer: any block, group, stack and persistent groups find the same") {
    const Mesh mesh = generate_scene("soup", 3000);
    const std::vector<Ray> rays = rays_for(mesh);
    const Bvh bvh = build(mesh, "locally-ordered");
    const Found expected = found_by_host(bvh, mesh, TriangleTest::watertight, rays);
    struct Row {
        Shape shape;
        std::uint32_t block, stack, persistent;
    };
    for (const Row& row : {Row{Shape::group, 1, 1, 3}, Row{Shape::group, 100, 5, 0}, Row{Shape::lane, 1, 1, 0},
                           Row{Shape::lane, 100, 5, 3}}) {
        INFO(to_string(row.shape) << ", " << row.block << ", " << row.stack << ", " << row.persistent);
        DeviceTracerOptions options = tracer_options(row.shape);
        options.work_group_size = 16;
        options.block_rays = row.block;
        options.stack_entries = row.stack;
        options.persistent_groups = row.persistent;
        DeviceTracer tracer(shared_context(), options);
        CHECK(tracer.shape() == row.shape);
        tracer.set_scene(bvh, mesh);
        check_same(found_by_device(tracer, rays), expected);
    }
}

TEST_CASE("device tracer: no tree is too deep for a ray's stack") {
    for (const auto& [length, each] : {std::pair{2u, 1u},
                                       {3u, 1u},
                                       {49u, 1u},
                                       {50u, 1u},
                                       {51u, 1u},
                                       {3000u, 1u},
                                       {100000u, 1u},
                                       {200u, 4u},
                                       {3000u, 4u}}) {
        const Chain chain(length, each);
        const std::vector<Ray> rays = Chain::rays(length > 3000 ? 10 : 200);
        const Found expected = found_by_host(chain.bvh, chain.mesh, TriangleTest::watertight, rays);
        CHECK(expected.hits[1].primitive == (length - 1) * each);
        CHECK(expected.closest_counts.back().triangles == length * each);
        for (const Shape shape : {Shape::group, Shape::lane}) {
            INFO(length << " leaves of " << each << ", " << to_string(shape));
            DeviceTracer tracer(shared_context(), tracer_options(shape));
            tracer.set_scene(chain.bvh, chain.mesh);
            check_same(found_by_device(tracer, rays), expected);
        }
    }
}

TEST_CASE("device tracer: triangles in any form, and copied in the order of the leaves") {
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
                    scene.copy = memory.copy();
                    tracer.enqueue_copy(shared_queue(), scene);
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

TEST_CASE("device tracer: a build, a copy and rays follow each other on any queue, and nobody waits") {
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
        scene.copy = memory.copy();
        cl::UserEvent written(shared_context().session().context());
        cl_event copied = nullptr, traced = nullptr;
        const cl::Event built = tree.enqueue(queue, {written()});
        cl_event built_event = built();
        tracer.enqueue_copy(queue(), scene, {&built_event, 1}, &copied);
        tracer.enqueue_closest(queue(), scene, memory.rays(), {&copied, 1}, &traced);
        const cl::Event copy(copied), end(traced);
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
        scene.copy = memory.copy();
        const OpenClCalls calls = opencl_calls_of([&] {
            tree.enqueue_only();
            tracer.enqueue_copy(shared_queue(), scene);
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
        DeviceScene copied = scene_of(tree);
        copied.copy = memory.copy();
        tracer.enqueue_copy(shared_queue(), copied);
        tracer.enqueue_copy(shared_queue(), DeviceScene{});
        for (const DeviceScene& scene : {scene_of(tree), copied, DeviceScene{}}) {
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

TEST_CASE("device tracer: more rays than are on the device at a time, and scenes one after the other") {
    const Mesh mesh = random_triangles(8);
    const std::vector<Ray> some = rays_for(mesh, 20);
    std::vector<Ray> rays;
    while (rays.size() < (std::size_t{1} << 20) + 5000)
        rays.insert(rays.end(), some.begin(), some.end());
    const Bvh bvh = build(mesh, "median");
    DeviceTracer tracer(shared_context());
    tracer.set_scene(bvh, mesh);
    check_same(found_by_device(tracer, rays), found_by_host(bvh, mesh, TriangleTest::watertight, rays));
    CHECK(opencl_calls_of([&] { (void)found_by_device(tracer, some); }).buffers == 0);

    const Mesh other = random_triangles(1000, 2);
    const Bvh other_bvh = build(other, "median");
    tracer.set_scene(other_bvh, other);
    DeviceTracer moved = std::move(tracer);
    check_same(found_by_device(moved, some), found_by_host(other_bvh, other, TriangleTest::watertight, some));
}

TEST_CASE("device tracer: options out of range are refused") {
    const auto expect_refused = [](std::initializer_list<std::string> words, auto&& change) {
        DeviceTracerOptions options = tracer_options(Shape::group);
        change(options);
        expect_error(ErrorCode::invalid_input, words, [&] { DeviceTracer(shared_context(), options); });
    };
    expect_refused({"work_group_size is 1"}, [](auto& o) { o.work_group_size = 1; });
    expect_refused({"block_rays is 65537"}, [](auto& o) { o.block_rays = 65537; });
    expect_refused({"stack_entries is 1025"}, [](auto& o) { o.stack_entries = 1025; });
    expect_refused({"persistent_groups is 65537"}, [](auto& o) { o.persistent_groups = 65537; });
}

TEST_CASE("device tracer: what is wrong with a scene of the host, or with spans, is named") {
    const Mesh mesh = random_triangles(10);
    const Bvh bvh = build(mesh, "median");
    DeviceTracer tracer(shared_context());
    std::vector<Ray> rays(3);
    std::vector<Hit> hits(3);
    std::vector<std::uint8_t> is_hit(2);
    std::vector<RayCounts> counts(1);
    expect_error(ErrorCode::invalid_input, {"no scene", "set_scene"}, [&] { tracer.closest(rays, hits); });
    tracer.set_scene(bvh, mesh);
    expect_error(ErrorCode::invalid_input, {"is_hit", "2 rays", "are 3"}, [&] { tracer.any(rays, is_hit); });
    expect_error(ErrorCode::invalid_input, {"counts", "1 rays", "are 3"}, [&] { tracer.closest(rays, hits, counts); });
    Bvh broken = bvh;
    broken.nodes[0].first = 0;
    expect_error(ErrorCode::invalid_input, {"node 0"}, [&] { tracer.set_scene(broken, mesh); });
    expect_error(ErrorCode::invalid_input, {"no scene"}, [&] { tracer.closest(rays, hits); });
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
    expect_refused({"the copy", "needs", "bytes"}, [&](Arguments& a) { a.scene.copy = {read_only(), (1 << 20) - 64}; });
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
    Arguments copy = sound;
    const cl::Buffer large(shared_context().session().context(), CL_MEM_READ_WRITE, 1 << 20);
    copy.scene.copy = {large(), 8};
    expect_error(ErrorCode::invalid_input, {"the copy", "multiple of 64"},
                 [&] { tracer.enqueue_copy(copy.queue, copy.scene); });
    copy.scene.copy = {read_only()};
    expect_error(ErrorCode::invalid_input, {"the copy", "CL_MEM_READ_WRITE"},
                 [&] { tracer.enqueue_copy(copy.queue, copy.scene); });
    DeviceRays too_many = sound.rays;
    too_many.count = kMaxDeviceRays + 1;
    expect_error(ErrorCode::unsupported, {"2147483648 rays", "2147483647"},
                 [&] { tracer.enqueue_any(sound.queue, sound.scene, too_many); });
    tracer.enqueue_closest(sound.queue, sound.scene, sound.rays);
    queue.finish();
}
