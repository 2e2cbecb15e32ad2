// Layouts that the device makes: the bytes of the host's.
#include <catch2/catch.hpp>
#include <cstring>

#include "clbvh/device/device_tracer.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/wide.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/device_rays.hpp"
#include "support/device_tree.hpp"
#include "support/found_rays.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const cl::CommandQueue& queue() {
    return shared_context().session().queue();
}

template <typename T>
cl::Buffer upload(const std::vector<T>& values) {
    const std::size_t bytes = values.size() * sizeof(T);
    const cl::Buffer buffer(shared_context().session().context(), CL_MEM_READ_WRITE, std::max<std::size_t>(bytes, 64));
    if (bytes > 0) queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, bytes, values.data());
    return buffer;
}

/// A tree and a mesh of the host's in device memory.
struct UploadedScene {
    cl::Buffer nodes, ids, vertices, indices;
    DeviceScene scene;

    UploadedScene(const Bvh& bvh, const Mesh& mesh)
        : nodes(upload(bvh.nodes)),
          ids(upload(bvh.primitive_ids)),
          vertices(upload(mesh.vertices)),
          indices(upload(mesh.triangles)) {
        scene.bvh = {{nodes()},
                     static_cast<std::uint32_t>(bvh.nodes.size()),
                     {ids()},
                     static_cast<std::uint32_t>(bvh.primitive_ids.size())};
        scene.triangles.count = static_cast<std::uint32_t>(mesh.triangles.size());
        scene.triangles.vertices = {vertices()};
        scene.triangles.indices = {indices()};
    }
};

template <typename T>
std::vector<T> read_span(const DeviceSpan& span, std::size_t count) {
    std::vector<T> values(count);
    if (count > 0) {
        queue().enqueueReadBuffer(cl::Buffer(span.buffer, true), CL_TRUE, span.offset, count * sizeof(T),
                                  values.data());
    }
    return values;
}

template <typename Array, typename T>
bool same_elements(const Array& expected, const std::vector<T>& found) {
    return expected.size() == found.size() &&
           (found.empty() || std::memcmp(expected.data(), found.data(), found.size() * sizeof(T)) == 0);
}

/// What differs between the layout in device memory and the host's; empty where nothing does.
std::string difference(const DeviceScene& scene, const Wide8& expected) {
    const DeviceWide8 parts = DeviceTracer::wide8_of(scene);
    const auto header = read_span<std::uint32_t>(parts.header, 3);
    if (header[0] != expected.nodes.size()) return "number of nodes";
    if (header[1] != expected.blocks.size()) return "number of blocks";
    if (header[2] != expected.depth) return "depth";
    if (!same_elements(expected.nodes, read_span<WideNode<8>>(parts.nodes, header[0]))) return "nodes";
    if (!same_elements(expected.blocks, read_span<TriangleBlock>(parts.blocks, header[1]))) return "blocks";
    return {};
}

void expect_host_layout(DeviceScene scene, const Wide8& expected) {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        INFO(to_string(shape));
        DeviceTracer tracer(shared_context(), tracer_options(shape));
        const DeviceRayMemory memory(tracer, scene.bvh, std::vector<Ray>(1));
        scene.layout = memory.layout();
        tracer.enqueue_layout(queue()(), scene);
        CHECK(difference(scene, expected).empty());
        CHECK(memory.guards_are_whole());
    }
}

void expect_host_layout(const Bvh& bvh, const Mesh& mesh) {
    const UploadedScene uploaded(bvh, mesh);
    expect_host_layout(uploaded.scene, make_layout<Wide8>(bvh, mesh));
}

}  // namespace

TEST_CASE("device layout: the host's bytes, of any builder's tree over any generated scene") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 3000);
        for (const BuilderInfo& builder : builders()) {
            for (const std::uint32_t max_leaf : {0u, 8u}) {
                INFO(scene.name << ", " << builder.id << ", leaves of " << max_leaf);
                BuildOptions options;
                options.max_leaf_size = max_leaf;
                expect_host_layout(build(mesh, builder.id, options), mesh);
            }
        }
    }
}

TEST_CASE("device layout: the host's bytes where a tree is cut into many pieces") {
    const Mesh mesh = generate_scene("city", 60000);
    expect_host_layout(build(mesh, "binned-sah"), mesh);
    expect_host_layout(build(mesh, "sbvh"), mesh);
    const Mesh chain = generate_scene("soup", 20000);
    expect_host_layout(chain_tree(chain), chain);
}

TEST_CASE("device layout: small trees, chains, and leaves of any size") {
    for (const std::uint32_t count : {1u, 2u, 3u, 4u, 5u, 9u, 40u}) {
        const Mesh mesh = generate_scene("soup", count);
        INFO(count);
        expect_host_layout(build(mesh, "median"), mesh);
        if (count > 1) expect_host_layout(chain_tree(mesh), mesh);
    }
    for (const std::uint32_t count : {1u, 4u, 5u, 32u, 33u, 64u, 256u, 257u, 3000u}) {
        const Mesh mesh = generate_scene("soup", count);
        Bvh leaf = build(mesh, "median");
        for (std::uint32_t i = 0; i < count; ++i)
            leaf.primitive_ids[i] = count - 1 - i;
        leaf.nodes = {leaf.nodes[0], Node{}};
        leaf.nodes[0].first = 0;
        leaf.nodes[0].count = count;
        INFO(count);
        expect_host_layout(leaf, mesh);
        const Mesh twice = generate_scene("soup", 2 * count);
        Bvh pair = build(twice, "median");
        pair.nodes = {pair.nodes[0], Node{}, pair.nodes[0], pair.nodes[0]};
        pair.nodes[0].first = 2;
        pair.nodes[0].count = 0;
        pair.nodes[2].first = 0;
        pair.nodes[3].first = count;
        pair.nodes[2].count = pair.nodes[3].count = count;
        expect_host_layout(pair, twice);
    }
    const Mesh line = line_of_points(500);
    expect_host_layout(build(line, "median"), line);
}

TEST_CASE("device layout: trees of the device's own, with inactive primitives and without any") {
    DeviceBuilder builder("hploc", shared_context());
    for (const std::uint32_t count : {1u, 100u, 20000u}) {
        for (const bool has_inactive : {false, true}) {
            Mesh mesh = random_triangles(count);
            if (has_inactive) deactivate_triangles(mesh, 0, 3);
            DeviceTree tree(builder, input_layouts().front(), mesh);
            tree.enqueue();
            INFO(count << ", " << has_inactive);
            const auto& triangles = std::get<DeviceTriangles>(tree.input());
            const DeviceScene scene{DeviceBvh::of(tree.result(), triangles.count), triangles, {}};
            const Bvh bvh = tree.read();
            expect_host_layout(scene, make_layout<Wide8>(bvh, mesh));
        }
    }
}
