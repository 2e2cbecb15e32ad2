// Layouts that the device makes: the bytes of the host's.
#include <catch2/catch.hpp>
#include <cstring>

#include "clbvh/device/device_optimizer.hpp"
#include "clbvh/device/device_refitter.hpp"
#include "clbvh/device/device_tracer.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/layout/wide.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/device_rays.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/found_rays.hpp"
#include "support/hard_trees.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"
#include "support/refit_memory.hpp"
#include "support/uploaded_scene.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const cl::CommandQueue& queue() {
    return shared_context().session().queue();
}

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

template <typename Node, typename Element>
std::string difference(const DeviceScene& scene, const LayoutArray<Node>& nodes, const LayoutArray<Element>& elements,
                       std::uint32_t depth) {
    const DeviceLayout parts = DeviceTracer::layout_of(scene);
    const auto header = read_span<std::uint32_t>(parts.header, 3);
    if (header[0] != nodes.size()) return "number of nodes";
    if (header[1] != elements.size()) return "number of elements";
    if (header[2] != depth) return "depth";
    if (!same_elements(nodes, read_span<Node>(parts.nodes, header[0]))) return "nodes";
    if (!same_elements(elements, read_span<Element>(parts.elements, header[1]))) return "elements";
    return {};
}

/// What differs between the layout in device memory and the host's; empty where nothing does.
template <std::uint32_t Width>
std::string difference(const DeviceScene& scene, const WideLayout<Width>& expected) {
    return difference(scene, expected.nodes, expected.blocks, expected.depth);
}

std::string difference(const DeviceScene& scene, const Compressed8& expected) {
    return difference(scene, expected.nodes, expected.triangles, expected.depth);
}

template <typename Layout>
std::string difference(const DeviceScene& scene, const Layout& expected) {
    return difference(scene, expected.nodes, expected.primitive_ids, expected.depth);
}

template <typename Layout>
void expect_host_layout(DeviceTracer& tracer, DeviceScene scene, LayoutKind kind, const Layout& expected) {
    const DeviceRayMemory memory(tracer, scene.bvh, std::vector<Ray>(1), kind);
    scene.layout = memory.layout();
    scene.layout_kind = kind;
    INFO("kind " << to_string(kind));
    tracer.enqueue_layout(queue()(), scene);
    CHECK(difference(scene, expected) == "");
    CHECK(memory.guards_are_whole());
}

void expect_host_layouts(const DeviceScene& scene, const Bvh& bvh, const Mesh& mesh) {
    const auto wide8 = make_layout<Wide8>(bvh, mesh);
    const auto wide4 = make_layout<Wide4>(bvh, mesh);
    const auto compressed8 = make_layout<Compressed8>(bvh, mesh);
    const auto skip = make_layout<SkipLayout>(bvh);
    const auto pair = make_layout<PairLayout>(bvh);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        INFO(to_string(shape));
        DeviceTracer tracer(shared_context(), tracer_options(shape));
        expect_host_layout(tracer, scene, LayoutKind::wide8, wide8);
        expect_host_layout(tracer, scene, LayoutKind::wide4, wide4);
        expect_host_layout(tracer, scene, LayoutKind::compressed8, compressed8);
        expect_host_layout(tracer, scene, LayoutKind::skip, skip);
        expect_host_layout(tracer, scene, LayoutKind::pair, pair);
    }
}

void expect_host_layouts(const Bvh& bvh, const Mesh& mesh) {
    const UploadedScene uploaded(bvh, mesh);
    expect_host_layouts(uploaded.scene, bvh, mesh);
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
                expect_host_layouts(build(mesh, builder.id, options), mesh);
            }
        }
    }
}

TEST_CASE("device layout: the host's bytes where a tree is cut into many pieces") {
    const Mesh mesh = generate_scene("city", 60000);
    expect_host_layouts(build(mesh, "binned-sah"), mesh);
    expect_host_layouts(build(mesh, "sbvh"), mesh);
    const Mesh chain = generate_scene("soup", 20000);
    expect_host_layouts(chain_tree(chain), chain);
}

TEST_CASE("device layout: grids of compressed8 are the host's far from the origin, at its sides, and where flat") {
    const Mesh mesh = generate_scene("soup", 2000);
    for (const float scale : {1.0f, 1e-30f, 1e11f}) {
        for (const float offset : {0.0f, 3e6f}) {
            Mesh placed = mesh;
            for (Vec3& vertex : placed.vertices)
                vertex = {scale * (vertex.x + offset), scale * (vertex.y - offset), scale * vertex.z};
            for (std::size_t i = 0; i < placed.vertices.size(); i += 3)
                placed.vertices[i].y = i % 2 == 0 ? 0.0f : -0.0f;
            INFO(scale << ", " << offset);
            expect_host_layouts(build(placed, "binned-sah"), placed);
        }
    }
}

TEST_CASE("device layout: small trees, chains, and leaves of any size") {
    for (const std::uint32_t count : {1u, 2u, 3u, 4u, 5u, 9u, 40u}) {
        const Mesh mesh = generate_scene("soup", count);
        INFO(count);
        expect_host_layouts(build(mesh, "median"), mesh);
        if (count > 1) expect_host_layouts(chain_tree(mesh), mesh);
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
        expect_host_layouts(leaf, mesh);
        const Mesh twice = generate_scene("soup", 2 * count);
        Bvh pair = build(twice, "median");
        pair.nodes = {pair.nodes[0], Node{}, pair.nodes[0], pair.nodes[0]};
        pair.nodes[0].first = 2;
        pair.nodes[0].count = 0;
        pair.nodes[2].first = 0;
        pair.nodes[3].first = count;
        pair.nodes[2].count = pair.nodes[3].count = count;
        expect_host_layouts(pair, twice);
    }
    const Mesh line = line_of_points(500);
    expect_host_layouts(build(line, "median"), line);
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
            expect_host_layouts(scene, bvh, mesh);
        }
    }
}

namespace {

Mesh moved(Mesh mesh, float way) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const auto phase = static_cast<float>(i % 97);
        mesh.vertices[i].x += way * std::sin(phase);
        mesh.vertices[i].z += way * std::cos(3 * phase);
    }
    return mesh;
}

/// What refits of an uploaded scene take.
struct Refits {
    DeviceRefitter refitter;
    DeviceScene scene;
    cl::Buffer order, scratch, sah;

    Refits(const DeviceScene& refitted, Shape shape)
        : refitter(make_refitter(shape)),
          scene(refitted),
          order(filled_buffer(sizes().order)),
          scratch(filled_buffer(std::max(sizes().scratch, sizes().cost_scratch))),
          sah(filled_buffer(8)) {
        refitter.enqueue_order(queue()(), scene.bvh, order);
    }
    [[nodiscard]] DeviceRefitSizes sizes() const { return refitter.sizes(scene.bvh.node_count, scene.triangles.count); }
    void enqueue(const DeviceSpan& layout) {
        refitter.enqueue(queue()(), scene.bvh, {scene.triangles, order, scratch, sah, layout});
    }
};

void write_vertices(const UploadedScene& uploaded, const Mesh& mesh) {
    queue().enqueueWriteBuffer(uploaded.vertices, CL_TRUE, 0, mesh.vertices.size() * sizeof(Vec3),
                               mesh.vertices.data());
}

void expect_stale(DeviceTracer& tracer, const DeviceScene& scene, const DeviceRays& rays) {
    const OpenClCalls calls = opencl_calls_of([&] {
        expect_error(ErrorCode::invalid_input, {"the layout", "no wide8 layout of this tree", "refitted since"},
                     [&] { tracer.enqueue_closest(queue()(), scene, rays); });
        expect_error(ErrorCode::invalid_input, {"the layout"}, [&] { tracer.enqueue_any(queue()(), scene, rays); });
    });
    CHECK(calls.launches == 0);
}

void expect_hits(DeviceTracer& tracer, const DeviceScene& scene, const DeviceRayMemory& memory, const Found& expected) {
    Found found = expected;
    tracer.enqueue_closest(queue()(), scene, memory.rays());
    found.hits = memory.hits();
    found.closest_counts = memory.counts();
    check_same(found, expected);
    DeviceRays uncounted = memory.rays();
    uncounted.counts = {};
    tracer.enqueue_closest(queue()(), scene, uncounted);
    found.hits = memory.hits();
    tracer.enqueue_any(queue()(), scene, uncounted);
    found.is_hit = memory.bytes();
    check_same(found, expected);
}

}  // namespace

TEST_CASE("device layout: refitted behind its tree it is the host's refitted layout, and gives the tree's hits") {
    const Mesh mesh = generate_scene("city", 5000);
    for (const char* id : {"binned-sah", "sbvh"}) {
        for (const Shape shape : {Shape::group, Shape::lane}) {
            INFO(id << ", " << to_string(shape));
            Bvh bvh = build(mesh, id);
            const UploadedScene uploaded(bvh, mesh);
            DeviceTracer tracer(shared_context(), tracer_options(shape));
            const std::vector<Ray> rays = rays_for(mesh, 50);
            const DeviceRayMemory memory(tracer, uploaded.scene.bvh, rays);
            DeviceScene scene = uploaded.scene;
            scene.layout = memory.layout();
            tracer.enqueue_layout(queue()(), scene);
            Refits refits(scene, shape);
            Wide8 expected = make_layout<Wide8>(bvh, mesh);
            for (const float way : {0.02f, 0.3f, 0.0f}) {
                const Mesh frame = moved(mesh, way);
                write_vertices(uploaded, frame);
                refits.enqueue(scene.layout);
                refit(expected, frame);
                CHECK(difference(scene, expected).empty());
                bvh.nodes = read_span<Node>(scene.bvh.nodes, bvh.nodes.size());
                expect_hits(tracer, scene, memory, found_by_host(bvh, frame, TriangleTest::watertight, rays));
                CHECK(memory.guards_are_whole());
            }
        }
    }
}

TEST_CASE("device layout: one that is older than its tree is never traced") {
    const Mesh mesh = generate_scene("soup", 3000), frame = moved(mesh, 0.1f);
    Bvh bvh = build(mesh, "median");
    const UploadedScene uploaded(bvh, mesh);
    DeviceTracer tracer(shared_context());
    const std::vector<Ray> rays = rays_for(mesh, 50);
    const DeviceRayMemory memory(tracer, uploaded.scene.bvh, rays), other(tracer, uploaded.scene.bvh, rays);
    DeviceScene scene = uploaded.scene, second = uploaded.scene;
    scene.layout = memory.layout();
    second.layout = other.layout();
    expect_stale(tracer, scene, memory.rays());  // there is none yet
    tracer.enqueue_layout(queue()(), scene);
    tracer.enqueue_layout(queue()(), second);
    Refits refits(scene, Shape::automatic);
    refits.refitter.enqueue_cost(queue()(), scene.bvh, refits.scratch, refits.sah);
    expect_hits(tracer, scene, memory, found_by_host(bvh, mesh, TriangleTest::watertight, rays));

    // A refit of the tree and of one layout leaves the other behind; it cannot be refitted then either.
    write_vertices(uploaded, frame);
    refits.enqueue(scene.layout);
    bvh.nodes = read_span<Node>(scene.bvh.nodes, bvh.nodes.size());
    const Found expected = found_by_host(bvh, frame, TriangleTest::watertight, rays);
    expect_hits(tracer, scene, memory, expected);
    expect_stale(tracer, second, other.rays());
    expect_error(ErrorCode::invalid_input, {"the layout", "no wide8 layout of this tree"},
                 [&] { refits.enqueue(second.layout); });
    refits.enqueue({});
    expect_stale(tracer, scene, memory.rays());
    tracer.enqueue_layout(queue()(), scene);
    expect_hits(tracer, scene, memory, expected);

    DeviceOptimizer optimizer("treelet", shared_context());
    const cl::Buffer scratch = filled_buffer(optimizer.scratch_bytes(scene.bvh.node_count));
    optimizer.enqueue(queue()(), scene.bvh, scratch);
    expect_stale(tracer, scene, memory.rays());
    tracer.enqueue_layout(queue()(), scene);
    DeviceScene fewer = scene;
    fewer.bvh.node_count -= 2;
    expect_stale(tracer, fewer, memory.rays());
    // Memory that was used for something else is no layout any more.
    DeviceRays into_layout = other.rays();
    into_layout.results = memory.layout();
    tracer.enqueue_closest(queue()(), uploaded.scene, into_layout);
    expect_stale(tracer, scene, memory.rays());
    queue().finish();
}

TEST_CASE("device layout: rays go through wide8 alone, and what is no kind is refused") {
    const Mesh mesh = generate_scene("soup", 300);
    const UploadedScene uploaded(build(mesh, "median"), mesh);
    DeviceTracer tracer(shared_context());
    const DeviceRayMemory memory(tracer, uploaded.scene.bvh, rays_for(mesh, 5));
    DeviceScene scene = uploaded.scene;
    scene.layout = memory.layout();
    tracer.enqueue_layout(queue()(), scene);
    DeviceScene skip = scene;
    skip.layout_kind = LayoutKind::skip;
    skip.triangles = {};
    tracer.enqueue_layout(queue()(), skip);
    expect_stale(tracer, scene, memory.rays());  // overwritten
    expect_error(ErrorCode::invalid_input, {"the layout's kind is skip", "wide8"},
                 [&] { tracer.enqueue_closest(queue()(), skip, memory.rays()); });
    scene.layout_kind = LayoutKind{99};
    CHECK(tracer.sizes(scene.bvh, scene.layout_kind).layout == 0);
    CHECK(DeviceTracer::layout_of(scene).nodes.buffer == nullptr);
    expect_error(ErrorCode::invalid_input, {"no layout of kind 99", "layout_kind"},
                 [&] { tracer.enqueue_layout(queue()(), scene); });
    queue().finish();
}

TEST_CASE("device layout: a build over the same memory is a new tree") {
    const Mesh mesh = random_triangles(2000);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), mesh);
    tree.enqueue();
    const auto& triangles = std::get<DeviceTriangles>(tree.input());
    DeviceScene scene{DeviceBvh::of(tree.result(), triangles.count), triangles, {}};
    DeviceTracer tracer(shared_context());
    const std::vector<Ray> rays = rays_for(mesh, 20);
    const DeviceRayMemory memory(tracer, scene.bvh, rays);
    scene.layout = memory.layout();
    tracer.enqueue_layout(queue()(), scene);
    tracer.enqueue_closest(queue()(), scene, memory.rays());
    tree.enqueue();
    expect_stale(tracer, scene, memory.rays());
    tracer.enqueue_layout(queue()(), scene);
    expect_hits(tracer, scene, memory, found_by_host(tree.read(), mesh, TriangleTest::watertight, rays));
}

TEST_CASE("device layout: buffers and events of OpenCL's C++ headers are taken as they are") {
    const Mesh mesh = generate_scene("soup", 500);
    const Bvh bvh = build(mesh, "median");
    const UploadedScene uploaded(bvh, mesh);
    DeviceTracer tracer(shared_context());
    const cl::Context& context = shared_context().session().context();
    const cl::Buffer memory(context, CL_MEM_READ_WRITE, tracer.sizes(uploaded.scene.bvh).layout + 64);
    DeviceScene scene = uploaded.scene;
    scene.layout = {memory, 64};
    const cl::UserEvent first(context), second(context);
    const std::vector<cl::Event> events{first, second};
    cl_event end = nullptr;
    tracer.enqueue_layout(queue()(), scene, events, &end);
    const cl::Event laid_out(end);
    queue().flush();
    CHECK(laid_out.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
    cl::UserEvent(first).setStatus(CL_COMPLETE);
    cl::UserEvent(second).setStatus(CL_COMPLETE);
    laid_out.wait();
    CHECK(difference(scene, make_layout<Wide8>(bvh, mesh)).empty());
}
