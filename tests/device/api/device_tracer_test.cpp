// Rays from host memory: the host tracer's hits and counts, bit for bit, whatever the tree.
#include "clbvh/device/device_tracer.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <catch2/catch.hpp>

#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/found_rays.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

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

}  // namespace

TEST_CASE("a device tracer checks its tree within a group of tasks that is cancelled, too") {
    const Mesh mesh = load_scene("gen:soup:40000");
    const Bvh tree = built_tree("median", mesh);
    Bvh wrong = tree;
    wrong.primitive_ids.back() = 4000000000U;
    DeviceTracer tracer(shared_context());
    tbb::task_group_context group;
    tbb::parallel_for(
        0, 1,
        [&](int) {
            group.cancel_group_execution();
            CHECK_NOTHROW(tracer.set_scene(tree, mesh));
            expect_error(ErrorCode::invalid_input, {"primitive 4000000000 is out of range"},
                         [&] { tracer.set_scene(wrong, mesh); });
        },
        group);
}

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
    Node root = built_tree("median", mesh).nodes[0];
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

TEST_CASE("device tracer: any block, group and stack find the same") {
    const Mesh mesh = generate_scene("soup", 3000);
    const std::vector<Ray> rays = rays_for(mesh);
    const Bvh bvh = build(mesh, "locally-ordered");
    const Found expected = found_by_host(bvh, mesh, TriangleTest::watertight, rays);
    struct Row {
        Shape shape;
        std::uint32_t block, stack;
    };
    for (const Row& row :
         {Row{Shape::group, 1, 1}, Row{Shape::group, 100, 5}, Row{Shape::lane, 1, 1}, Row{Shape::lane, 100, 5}}) {
        INFO(to_string(row.shape) << ", " << row.block << ", " << row.stack);
        DeviceTracerOptions options = tracer_options(row.shape);
        options.work_group_size = 16;
        options.block_rays = row.block;
        options.stack_entries = row.stack;
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

TEST_CASE("device tracer: more rays than are on the device at a time, and scenes one after the other") {
    const Mesh mesh = random_triangles(8);
    const std::vector<Ray> some = rays_for(mesh, 20);
    std::vector<Ray> rays;
    while (rays.size() < (std::size_t{1} << 20) + 5000)
        rays.insert(rays.end(), some.begin(), some.end());
    const Bvh bvh = built_tree("median", mesh);
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
}

TEST_CASE("device tracer: what is wrong with a scene of the host, or with spans, is named") {
    const Mesh mesh = random_triangles(10);
    const Bvh bvh = built_tree("median", mesh);
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
