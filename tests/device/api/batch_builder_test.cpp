// Many small trees in one launch: each is the tree that Builder makes of its mesh alone.
#include "clbvh/device/batch_builder.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "clbvh/io/scene.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"
#include "support/views.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Options whose chunks are so small that little meshes fill several.
BuildOptions small_chunks(Shape shape, std::uint32_t radius = 8) {
    BuildOptions options = options_of(shape, radius);
    options.ploc.chunk_size = 64;
    options.ploc.work_group_size = 128;
    return options;
}

/// Meshes of many sizes: empty ones, inactive triangles, nothing but inactive ones, and equal boxes among them.
std::vector<Mesh> many_meshes() {
    std::vector<Mesh> meshes;
    for (const std::uint32_t size : {0u, 1u, 2u, 3u, 12u, 31u, 32u, 33u, 100u, 255u, 256u, 257u, 1000u, 4000u, 0u})
        meshes.push_back(random_triangles(size));
    for (const std::string_view scene : {"clustered", "particles", "hair", "line", "city"})
        meshes.push_back(generate_scene(scene, 700));
    Mesh holes = random_triangles(300);
    for (std::size_t i = 0; i < 300; i += 3)
        holes.vertices[holes.triangles[i][1]].x = kNan;
    meshes.push_back(holes);
    for (Vec3& vertex : holes.vertices)
        vertex.z = kNan;
    meshes.push_back(holes);
    Mesh equal;
    equal.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 1}};
    equal.triangles.assign(1000, {0, 1, 2});
    meshes.push_back(equal);
    return meshes;
}

/// Checks that tree i is Builder's over mesh i.
void expect_own_trees(const std::vector<Bvh>& trees, const std::vector<Mesh>& meshes, const BuildOptions& options) {
    Builder builder = make_builder("plocpp", options);
    REQUIRE(trees.size() == meshes.size());
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        INFO("mesh " << i << " of " << meshes[i].triangles.size() << " triangles, " << to_string(options.device.shape));
        CHECK(same_bytes(trees[i], builder.build(meshes[i])));
    }
}

std::vector<MeshView> views_of(const std::vector<Mesh>& meshes) {
    return {meshes.begin(), meshes.end()};
}

/// The meshes one behind the other, and where each is. Its triangles count from the first of its vertices.
struct Joined {
    Mesh mesh;
    std::vector<BatchRange> ranges;

    explicit Joined(const std::vector<Mesh>& meshes) {
        for (const Mesh& part : meshes) {
            ranges.push_back({static_cast<std::uint32_t>(mesh.triangles.size()),
                              static_cast<std::uint32_t>(part.triangles.size()),
                              static_cast<std::uint32_t>(mesh.vertices.size())});
            mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
            mesh.triangles.insert(mesh.triangles.end(), part.triangles.begin(), part.triangles.end());
        }
    }
};

template <typename T>
cl::Buffer upload(const std::vector<T>& values) {
    const device::Session& session = shared_context().session();
    cl::Buffer buffer(session.context(), CL_MEM_READ_ONLY, values.size() * sizeof(T));
    session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, values.size() * sizeof(T), values.data());
    return buffer;
}

template <typename T>
std::vector<T> read_all(const cl::Buffer& buffer, std::size_t count) {
    std::vector<T> values(count);
    shared_context().session().queue().enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(T), values.data());
    return values;
}

cl::Buffer make_buffer(std::uint64_t bytes) {
    return {shared_context().session().context(), CL_MEM_READ_WRITE, bytes};
}

/// Device memory of one batch.
struct BatchMemory {
    BatchMemory(const BatchBuilder& builder, const std::vector<BatchRange>& ranges, std::uint32_t primitives)
        : sizes(builder.sizes(primitives, ranges.size())),
          table(upload(ranges)),
          nodes(make_buffer(sizes.nodes)),
          ids(make_buffer(sizes.primitive_ids)),
          scratch(make_buffer(sizes.scratch)),
          counts(make_buffer(4 * ranges.size())) {}

    [[nodiscard]] DeviceResult result() const { return {{nodes()}, {ids()}, {counts()}}; }
    [[nodiscard]] std::vector<Bvh> read(const std::vector<BatchRange>& ranges) const;

    DeviceBuildSizes sizes;
    cl::Buffer table, nodes, ids, scratch, counts;
};

std::vector<Bvh> BatchMemory::read(const std::vector<BatchRange>& ranges) const {
    const std::vector<Node> all_nodes = read_all<Node>(nodes, sizes.nodes / sizeof(Node));
    const std::vector<std::uint32_t> all_ids = read_all<std::uint32_t>(ids, sizes.primitive_ids / 4);
    const std::vector<std::uint32_t> active = read_all<std::uint32_t>(counts, ranges.size());
    std::vector<Bvh> trees(ranges.size());
    for (std::size_t i = 0; i < ranges.size(); ++i) {
        const auto first = static_cast<std::ptrdiff_t>(ranges[i].first_primitive);
        trees[i].primitive_count = ranges[i].primitive_count;
        if (active[i] > ranges[i].primitive_count) continue;
        trees[i].nodes.assign(all_nodes.begin() + 2 * first, all_nodes.begin() + 2 * (first + active[i]));
        trees[i].primitive_ids.assign(all_ids.begin() + first, all_ids.begin() + first + active[i]);
    }
    return trees;
}

}  // namespace

TEST_CASE("batch builder: every tree is Builder's, in both shapes") {
    const std::vector<Mesh> meshes = many_meshes();
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const BuildOptions& options : {options_of(shape), small_chunks(shape), small_chunks(shape, 1)}) {
            BatchBuilder builder(shared_context(), options);
            expect_own_trees(builder.build(views_of(meshes)), meshes, options);
        }
        BuildOptions exact = options_of(shape, 5);
        exact.ploc.neighbour_encoding = NeighbourEncoding::bits64;
        exact.ploc.neighbour_search = NeighbourSearch::scan;
        exact.device.code_bits = 33;
        BatchBuilder builder(shared_context(), exact);
        expect_own_trees(builder.build(views_of(meshes)), meshes, exact);
    }
}

TEST_CASE("batch builder: it is one launch, and later batches allocate nothing") {
    const std::vector<Mesh> meshes = many_meshes();
    const std::vector<MeshView> views = views_of(meshes);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        BatchBuilder builder(shared_context(), options_of(shape));
        BuildStats stats;
        (void)builder.build(views, &stats);
        CHECK(stats.launches == 1);
        CHECK(stats.peak_device_bytes > 0);
        const OpenClCalls calls = opencl_calls_of([&] { (void)builder.build(views); });
        CHECK(calls.launches == 1);
        CHECK(calls.buffers == 0);
        CHECK(calls.copied == meshes.size() * sizeof(BatchRange));  // meshes are written where the device reads them
        CHECK(calls.programs == 0);
        CHECK(opencl_calls_of([&] { (void)builder.build(std::span(views).first(8)); }).buffers == 0);
    }
}

TEST_CASE("batch builder: nothing to build is no error") {
    BatchBuilder builder(shared_context(), options_of(Shape::lane));
    CHECK(builder.build({}).empty());
    const std::vector<Mesh> empty(3);
    const std::vector<Bvh> trees = builder.build(views_of(empty));
    REQUIRE(trees.size() == 3);
    CHECK(trees[2].empty());
    const cl::CommandQueue& queue = shared_context().session().queue();
    const cl::Buffer counts = upload<std::uint32_t>({7, 8, 9});
    DeviceResult result;
    result.active_count = {counts(), 4};
    builder.enqueue(queue(), DeviceTriangles{}, {2, {}}, {}, result);
    builder.enqueue(queue(), DeviceTriangles{}, {}, {}, {});
    result.active_count.offset = 2;
    expect_error(ErrorCode::invalid_input, {"the active count's offset is 2"}, [&] {
        builder.enqueue(queue(), DeviceTriangles{}, {2, {}}, {}, result);
    });
    CHECK(read_all<std::uint32_t>(counts, 3) == std::vector<std::uint32_t>{7, 0, 0});
}

TEST_CASE("batch builder: meshes in memory of every layout", "[views]") {
    const std::vector<Mesh> meshes{mesh_with_inactive(), random_triangles(40), random_triangles(300)};
    std::vector<ViewedMesh> layouts;
    std::vector<MeshView> views;
    std::vector<Mesh> expected;
    for (const Mesh& mesh : meshes)
        for (ViewedMesh& layout : layouts_of(mesh)) {
            views.push_back(layout.view);
            expected.push_back(mesh);
            layouts.push_back(std::move(layout));
        }
    for (const Shape shape : {Shape::group, Shape::lane}) {
        BatchBuilder builder(shared_context(), options_of(shape));
        expect_own_trees(builder.build(views), expected, options_of(shape));
    }
    BatchBuilder builder(shared_context(), options_of(Shape::lane));
    views.back().vertex_stride = 8;
    expect_error(ErrorCode::invalid_input,
                 {"mesh " + std::to_string(views.size() - 1) + ": ", "the stride of the vertices is 8"},
                 [&] { (void)builder.build(views); });
    views.back() = views.front();
    views.back().indices = nullptr;
    views.back().triangle_count = 1;
    views.back().vertex_count = 0xfffffff0u;
    expect_error(ErrorCode::unsupported, {"mesh " + std::to_string(views.size() - 1) + ": the vertices", "2^32"},
                 [&] { (void)builder.build(views); });
}

TEST_CASE("batch builder: errors name the mesh and the triangle, and the builder still works") {
    std::vector<Mesh> meshes{random_triangles(10), random_triangles(20), random_triangles(30)};
    BatchBuilder builder(shared_context(), options_of(Shape::lane));
    meshes[1].triangles[7][2] = 60;
    expect_error(ErrorCode::invalid_input, {"mesh 1: triangle 7: vertex index 60"},
                 [&] { (void)builder.build(views_of(meshes)); });
    meshes[1].triangles[7][2] = 0;
    meshes[2].vertices[meshes[2].triangles[4][0]].y = std::numeric_limits<float>::infinity();
    expect_error(ErrorCode::invalid_input, {"mesh 2: triangle 4: coordinate y"},
                 [&] { (void)builder.build(views_of(meshes)); });
    meshes.pop_back();
    expect_own_trees(builder.build(views_of(meshes)), meshes, options_of(Shape::lane));
}

TEST_CASE("batch builder: options that it cannot keep are refused") {
    const auto expect_refused = [](const BuildOptions& options, const std::string& word) {
        expect_error(ErrorCode::unsupported, {word}, [&] { (void)BatchBuilder(shared_context(), options); });
    };
    BuildOptions options;
    options.max_leaf_size = 4;
    expect_refused(options, "max_leaf_size");
    options = {};
    options.device.morton_code = MortonCode::extended;
    expect_refused(options, "morton_code");
    options = {};
    options.device.code_bits = 63;
    expect_refused(options, "code_bits");
}

TEST_CASE("batch builder: ranges of the caller's buffers, in any form and on any queue") {
    const std::vector<Mesh> meshes = many_meshes();
    const Joined joined(meshes);
    Mesh absolute = joined.mesh;
    for (const BatchRange& range : joined.ranges) {
        for (std::uint32_t i = 0; i < range.primitive_count; ++i) {
            for (std::uint32_t& index : absolute.triangles[range.first_primitive + i])
                index += range.first_vertex;
        }
    }
    std::vector<BatchRange> from_zero = joined.ranges;
    for (BatchRange& range : from_zero)
        range.first_vertex = 0;
    const auto count = static_cast<std::uint32_t>(absolute.triangles.size());
    for (const Shape shape : {Shape::group, Shape::lane}) {
        BatchBuilder builder(shared_context(), options_of(shape));
        DeviceBuilder unused("lbvh", shared_context(), options_of(shape));
        for (const InputLayout& layout : input_layouts()) {
            INFO(layout.name << ", " << to_string(shape));
            const bool is_indexed =
                layout.kind == InputLayout::Kind::indexed_32 || layout.kind == InputLayout::Kind::indexed_16;
            const DeviceTree input(unused, layout, is_indexed ? joined.mesh : absolute);
            const std::vector<BatchRange>& ranges = is_indexed ? joined.ranges : from_zero;
            for (const cl::CommandQueue& queue : {own_queue(), out_of_order_queue()}) {
                if (queue() == nullptr) continue;
                const BatchMemory memory(builder, ranges, count);
                cl_event event = nullptr;
                const OpenClCalls calls = opencl_calls_of([&] {
                    builder.enqueue(queue(), input.input(),
                                    {static_cast<std::uint32_t>(ranges.size()), {memory.table()}}, {memory.scratch()},
                                    memory.result(), {}, &event);
                });
                CHECK(calls.buffers == 0);
                CHECK(calls.waits == 0);
                CHECK(calls.launches == 1);
                cl::Event(event).wait();
                expect_own_trees(memory.read(ranges), meshes, options_of(shape));
            }
        }
    }
}

TEST_CASE("batch builder: what is wrong with the arguments is named") {
    BatchBuilder builder(shared_context(), options_of(Shape::lane));
    const std::vector<BatchRange> ranges{{0, 10, 0}, {10, 20, 0}};
    const BatchMemory memory(builder, ranges, 30);
    DeviceBuilder unused("lbvh", shared_context());
    const DeviceTree input(unused, input_layouts().front(), random_triangles(30));
    cl_command_queue queue = shared_context().opencl_queue();
    DeviceResult no_counts = memory.result();
    no_counts.active_count = {};
    expect_error(ErrorCode::invalid_input, {"the active count has no buffer"}, [&] {
        builder.enqueue(queue, input.input(), {2, {memory.table()}}, {memory.scratch()}, no_counts);
    });
    expect_error(ErrorCode::invalid_input, {"the ranges needs 48 bytes"}, [&] {
        builder.enqueue(queue, input.input(), {3, {memory.table()}}, {memory.scratch()}, memory.result());
    });
    expect_error(ErrorCode::invalid_input, {"the ranges' offset is 2"}, [&] {
        builder.enqueue(queue, input.input(), {1, {memory.table(), 2}}, {memory.scratch()}, memory.result());
    });
    DeviceResult twice = memory.result();
    twice.primitive_ids = twice.nodes;
    expect_error(ErrorCode::invalid_input, {"the nodes and the primitive ids overlap"}, [&] {
        builder.enqueue(queue, input.input(), {2, {memory.table()}}, {memory.scratch()}, twice);
    });
    expect_error(ErrorCode::unsupported, {"build in parts"}, [&] { (void)builder.sizes(kMaxPrimitives + 1, 1); });
}
