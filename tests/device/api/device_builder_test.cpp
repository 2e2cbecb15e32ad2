// Builds on the caller's queue, from and into the caller's buffers: Builder's trees, with nothing allocated and nothing
// waited for.
#include "clbvh/device/device_builder.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>

#include "clbvh/core/validate.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

DeviceBuilder make_device_builder(std::string_view id, const BuildOptions& options = {}) {
    return {id, shared_context(), options};
}

/// Calls `check` with a builder of each that it takes in each shape, and with its options.
template <typename Check>
void for_each_device_builder(Check check) {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : enqueued_builders()) {
            INFO(id << ", " << to_string(shape));
            BuildOptions options = options_of(shape);
            options.ploc.single_group_threshold = 1000;
            DeviceBuilder builder = make_device_builder(id, options);
            check(builder);
        }
    }
}

Bvh tree_of_builder(const DeviceBuilder& like, const Mesh& mesh) {
    return Builder(like.info().id, shared_context(), like.options()).build(mesh);
}

/// A soup of which every 7th triangle is inactive.
Mesh mesh_with_holes(std::uint32_t triangles) {
    Mesh mesh = random_triangles(triangles);
    for (std::size_t i = 0; i < triangles; i += 7)
        mesh.vertices[mesh.triangles[i][i % 3]].y = kNan;
    return mesh;
}

bool builds_without_waiting(const DeviceBuilder& builder) {
    return builder.info().id != "ploc";
}

}  // namespace

TEST_CASE("device builder: the tree is Builder's, whatever form the primitives come in") {
    const Mesh mesh = mesh_with_holes(6000);
    for_each_device_builder([&](DeviceBuilder& builder) {
        const Bvh expected = tree_of_builder(builder, mesh);
        REQUIRE(expected.primitive_ids.size() < mesh.triangles.size());
        for (const InputLayout& layout : input_layouts()) {
            INFO(layout.name);
            DeviceTree tree(builder, layout, mesh);
            tree.enqueue();
            CHECK(same_bytes(tree.read(), expected));
            CHECK(tree.guards_are_whole());
        }
    });
}

TEST_CASE("device builder: meshes of any size, also where all primitives are inactive") {
    for_each_device_builder([](DeviceBuilder& builder) {
        for (const std::uint32_t size : {1u, 2u, 3u, 100u, 1023u, 20000u}) {
            INFO(size);
            const Mesh mesh = random_triangles(size);
            DeviceTree tree(builder, input_layouts().front(), mesh);
            tree.enqueue();
            CHECK(same_bytes(tree.read(), tree_of_builder(builder, mesh)));
            CHECK(tree.guards_are_whole());

            Mesh inactive = mesh;
            for (Vec3& vertex : inactive.vertices)
                vertex.z = kNan;
            DeviceTree none(builder, input_layouts().front(), inactive);
            none.enqueue();
            const Bvh bvh = none.read();
            CHECK(bvh.nodes.empty());
            const Node root = none.root();
            CHECK_FALSE(root.is_leaf());
            CHECK(root.lower[0] > root.upper[0]);
            CHECK(none.guards_are_whole());
        }
    });
}

TEST_CASE("device builder: leaves of several primitives leave zeros behind Builder's tree, optimised or not") {
    for (const char* const optimizers : {"", "reinsert", "treelet"}) {
        for (const Shape shape : {Shape::group, Shape::lane}) {
            BuildOptions options = options_of(shape);
            options.hploc.leaf_size = 4;
            options.optimizers = optimizers;
            options.optimize_on = OptimizeOn::device;
            DeviceBuilder builder = make_device_builder("hploc", options);
            for (const std::uint32_t size : {1u, 4u, 5u, 100u, 6000u, 20000u}) {
                INFO(optimizers << ", " << to_string(shape) << ", " << size);
                const Mesh mesh = mesh_with_holes(size);
                const Bvh expected = tree_of_builder(builder, mesh);
                DeviceTree tree(builder, input_layouts().front(), mesh);
                tree.enqueue();
                Bvh built = tree.read();
                CHECK(tree.guards_are_whole());
                REQUIRE(built.nodes.size() >= expected.nodes.size());
                const auto behind = built.nodes.begin() + static_cast<std::ptrdiff_t>(expected.nodes.size());
                CHECK(std::all_of(behind, built.nodes.end(), [](const Node& node) { return node == Node{}; }));
                built.nodes.erase(behind, built.nodes.end());
                CHECK(same_bytes(built, expected));
                CHECK(validate(expected, mesh).error == "");
            }
        }
    }
}

TEST_CASE("device builder: without primitives the active count is 0, and nothing else is touched") {
    for_each_device_builder([](DeviceBuilder& builder) {
        const DeviceBuildSizes sizes = builder.sizes(0);
        CHECK(sizes.nodes == 0);
        CHECK(sizes.primitive_ids == 0);
        CHECK(sizes.scratch == 0);
        const cl::CommandQueue& queue = shared_context().session().queue();
        const cl::Buffer count(shared_context().session().context(), CL_MEM_READ_WRITE, 12);
        const std::vector<std::uint32_t> before{7, 8, 9};
        queue.enqueueWriteBuffer(count, CL_TRUE, 0, 12, before.data());
        DeviceResult result;
        result.active_count = {count(), 4};
        cl_event event = nullptr;
        builder.enqueue(queue(), DeviceTriangles{}, {}, result, {}, &event);
        builder.enqueue(queue(), DeviceBoxes{}, {}, {});
        const cl::Event done(event);
        done.wait();
        std::vector<std::uint32_t> after(3);
        queue.enqueueReadBuffer(count, CL_TRUE, 0, 12, after.data());
        CHECK(after == std::vector<std::uint32_t>{7, 0, 9});
    });
}

TEST_CASE("device builder: a queue out of order gives the same tree, and so does Builder on it") {
    const Mesh mesh = mesh_with_holes(5000);
    const cl::CommandQueue queue = out_of_order_queue();
    if (queue() == nullptr) {
        WARN("SKIPPED: the device has no queues out of order");
        return;
    }
    for_each_device_builder([&](DeviceBuilder& builder) {
        const Bvh expected = tree_of_builder(builder, mesh);
        DeviceTree tree(builder, input_layouts().front(), mesh);
        for (int repetition = 0; repetition < 3; ++repetition) {
            tree.enqueue(queue).wait();
            CHECK(same_bytes(tree.read(), expected));
        }
    });
    const Context adopted = Context::adopt(queue());
    for (const std::string_view id : device_builders()) {
        INFO(id);
        BuildStats stats;
        Builder builder(id, adopted, options_of(Shape::lane));
        CHECK(same_bytes(builder.build(mesh, &stats), make_builder(id, options_of(Shape::lane)).build(mesh)));
        CHECK(stats.launches > 0);
    }
}

TEST_CASE("device builder: a build waits for its wait list, and the caller does not") {
    const Mesh mesh = random_triangles(3000);
    for (const cl::CommandQueue& queue : {shared_context().session().queue(), out_of_order_queue()}) {
        if (queue() == nullptr) continue;
        for_each_device_builder([&](DeviceBuilder& builder) {
            if (!builds_without_waiting(builder)) return;
            DeviceTree tree(builder, input_layouts().front(), mesh);
            tree.clear_input();
            cl::UserEvent written(shared_context().session().context());
            const cl::Event done = tree.enqueue(queue, {written()});
            queue.flush();
            CHECK(done.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
            tree.write_input(own_queue());
            written.setStatus(CL_COMPLETE);
            done.wait();
            CHECK(same_bytes(tree.read(), tree_of_builder(builder, mesh)));
        });
    }
}

TEST_CASE("device builder: nothing is allocated, built or waited for") {
    const Mesh mesh = random_triangles(30000);
    for_each_device_builder([&](DeviceBuilder& builder) {
        for (const InputLayout& layout : input_layouts()) {
            DeviceTree tree(builder, layout, mesh);
            OpenClCalls calls = opencl_calls_of([&] { tree.enqueue_only(); });
            CHECK(calls.launches > 0);
            CHECK(calls.buffers == 0);
            CHECK(calls.programs == 0);
            CHECK(calls.sub_buffers < 40);
            if (builds_without_waiting(builder)) {
                CHECK(calls.waits == 0);
            } else {
                CHECK(calls.waits > 0);
            }
            shared_context().session().queue().finish();
        }
    });
}

TEST_CASE("builder: later builds allocate nothing and build no program") {
    const Mesh mesh = random_triangles(30000);
    const Mesh smaller = random_triangles(20000);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            INFO(id << ", " << to_string(shape));
            Builder builder = make_builder(id, options_of(shape));
            builder.upload(mesh);
            CHECK(opencl_calls_of([&] { (void)builder.run(); }).buffers > 0);
            for (int repetition = 0; repetition < 2; ++repetition) {
                const OpenClCalls calls = opencl_calls_of([&] { (void)builder.run(); });
                CHECK(calls.launches > 0);
                CHECK(calls.buffers == 0);
                CHECK(calls.programs == 0);
                CHECK(calls.sub_buffers < 10);
            }
            builder.upload(smaller);
            const OpenClCalls calls = opencl_calls_of([&] { (void)builder.run(); });
            CHECK(calls.buffers == 0);
            CHECK(calls.programs == 0);
        }
    }
}

TEST_CASE("device builder: sizes grow with the primitives, and what is too large is refused with the limit") {
    for_each_device_builder([](DeviceBuilder& builder) {
        const DeviceBuildSizes small = builder.sizes(1000);
        CHECK(small.nodes == 64000);
        CHECK(small.primitive_ids == 4000);
        CHECK(builder.sizes(1001).scratch >= small.scratch);
        CHECK(builder.sizes(1000000).scratch < 75000000);
        expect_error(ErrorCode::unsupported, {"1073741824 primitives", "1073741823"},
                     [&] { (void)builder.sizes(kMaxPrimitives + 1); });
    });
    DeviceInfo info = shared_context().device();
    const std::uint64_t most = info.max_allocation_bytes;
    const DeviceBuilder builder = make_device_builder("plocpp");
    std::uint64_t count = most / 64;
    if (count >= kMaxPrimitives) {
        WARN("SKIPPED: the device allocates as much as any tree needs");
        return;
    }
    expect_error(ErrorCode::unsupported,
                 {std::to_string(count + 1) + " primitives", std::to_string(most) + " bytes at once"},
                 [&] { (void)builder.sizes(count + 1); });
}

TEST_CASE("device builder: leaves of several primitives have no room for as many primitives as others") {
    BuildOptions options = options_of(Shape::lane);
    options.hploc.leaf_size = 2;
    const DeviceBuilder builder = make_device_builder("hploc", options);
    expect_error(ErrorCode::unsupported, {"268435457 primitives", "268435456", "leaf_size"},
                 [&] { (void)builder.sizes((1u << 28) + 1); });
}

TEST_CASE("device builder: builders of the host and work of the host are refused") {
    expect_error(ErrorCode::unsupported, {"sweep-sah", "host"}, [] { (void)make_device_builder("sweep-sah"); });
    expect_error(ErrorCode::invalid_input, {"plok"}, [] { (void)make_device_builder("plok"); });
    BuildOptions options;
    options.max_leaf_size = 4;
    expect_error(ErrorCode::unsupported, {"hlbvh", "on the host", "lbvh"}, [&] { (void)make_device_builder("hlbvh"); });
    expect_error(ErrorCode::unsupported, {"max_leaf_size"}, [&] { (void)make_device_builder("lbvh", options); });
    options = {};
    options.presplit_level = 14;
    expect_error(ErrorCode::unsupported, {"presplit_level"}, [&] { (void)make_device_builder("lbvh", options); });
    options = {};
    options.split_quota = 0.3f;
    expect_error(ErrorCode::unsupported, {"split_quota"}, [&] { (void)make_device_builder("lbvh", options); });
    options = {};
    options.ploc.search_radius = 33;
    expect_error(ErrorCode::invalid_input, {"search_radius"}, [&] { (void)make_device_builder("ploc", options); });
}

TEST_CASE("device builder: what is wrong with the arguments is named, and nothing is enqueued") {
    const Mesh mesh = random_triangles(100);
    DeviceBuilder builder = make_device_builder("lbvh");
    const DeviceTree tree(builder, input_layouts().front(), mesh);
    const cl::CommandQueue& queue = shared_context().session().queue();
    const cl::Context other_context(queue.getInfo<CL_QUEUE_DEVICE>());
    const cl::Buffer foreign(other_context, CL_MEM_READ_WRITE, 1 << 20);
    const cl::Buffer read_only(shared_context().session().context(), CL_MEM_READ_ONLY, 1 << 20);
    const cl::CommandQueue foreign_queue(other_context, queue.getInfo<CL_QUEUE_DEVICE>());

    struct Arguments {
        cl_command_queue queue;
        DeviceTriangles input;
        DeviceSpan scratch;
        DeviceResult result;
        std::vector<cl_event> wait_list;
    };
    const Arguments sound{queue(), std::get<DeviceTriangles>(tree.input()), tree.scratch(), tree.result(), {}};
    const auto expect_refused = [&](std::initializer_list<std::string> words, auto&& change) {
        Arguments changed = sound;
        change(changed);
        const OpenClCalls calls = opencl_calls_of([&] {
            expect_error(ErrorCode::invalid_input, words, [&] {
                builder.enqueue(changed.queue, changed.input, changed.scratch, changed.result, changed.wait_list);
            });
        });
        CHECK(calls.launches == 0);
    };
    expect_refused({"queue is null"}, [](Arguments& a) { a.queue = nullptr; });
    expect_refused({"queue", "another OpenCL context"}, [&](Arguments& a) { a.queue = foreign_queue(); });
    expect_refused({"wait list", "null"}, [](Arguments& a) { a.wait_list = {nullptr}; });
    expect_refused({"the nodes", "no buffer"}, [](Arguments& a) { a.result.nodes = {}; });
    expect_refused({"the primitive ids", "another OpenCL context"}, [&](Arguments& a) {
        a.result.primitive_ids = {foreign(), 0};
    });
    expect_refused({"the scratch", "CL_MEM_READ_WRITE"}, [&](Arguments& a) { a.scratch = {read_only(), 0}; });
    expect_refused({"the scratch", "needs", "bytes from offset"}, [](Arguments& a) { a.scratch.offset += 1 << 20; });
    expect_refused({"the nodes", "multiple of"}, [](Arguments& a) { a.result.nodes.offset += 4; });
    expect_refused({"the nodes and the primitive ids overlap"},
                   [](Arguments& a) { a.result.primitive_ids = a.result.nodes; });
    expect_refused({"the scratch and the vertices overlap"}, [](Arguments& a) { a.input.vertices = a.scratch; });
    expect_refused({"the scratch", "CL_MEM_USE_HOST_PTR", "64 bytes"}, [](Arguments& a) {
        static std::vector<float> floats(1 << 20);
        // One float beyond a vector's alignment, wherever the array begins.
        const std::size_t aligned = (64 - reinterpret_cast<std::uintptr_t>(floats.data()) % 64) % 64 / sizeof(float);
        static const cl::Buffer unaligned(shared_context().session().context(), CL_MEM_USE_HOST_PTR,
                                          (floats.size() - 32) * sizeof(float), floats.data() + aligned + 1);
        a.scratch = {unaligned(), 0};
    });
    expect_refused({"the vertices", "CL_MEM_WRITE_ONLY"}, [](Arguments& a) {
        static const cl::Buffer write_only(shared_context().session().context(), CL_MEM_WRITE_ONLY, 1 << 20);
        a.input.vertices = {write_only(), 0};
    });
    expect_refused({"the indices and the scratch lie in one buffer", "sub-buffer"}, [&](Arguments& a) {
        static const cl::Buffer large(shared_context().session().context(), CL_MEM_READ_WRITE, 1 << 22);
        a.scratch = {large(), 0};
        a.input.indices = {large(), 1 << 21};
    });
    expect_refused({"the nodes and the indices overlap"}, [](Arguments& a) { a.input.indices = a.result.nodes; });
    expect_refused({"the active count's offset is 2"}, [](Arguments& a) { a.result.active_count.offset = 2; });
    expect_refused({"the vertices", "no buffer"}, [](Arguments& a) { a.input.vertices = {}; });
    expect_refused({"the vertices' stride is 8"}, [](Arguments& a) { a.input.vertex_stride = 8; });
    expect_refused({"the vertices' stride is 14"}, [](Arguments& a) { a.input.vertex_stride = 14; });
    expect_refused({"the indices' stride is 8"}, [](Arguments& a) { a.input.index_stride = 8; });
    expect_refused({"the indices' offset is 2"}, [](Arguments& a) { a.input.indices.offset = 2; });
    expect_refused({"the indices", "needs 1200 bytes from offset 0", "ends after 1000"}, [](Arguments& a) {
        static const cl::Buffer short_buffer(shared_context().session().context(), CL_MEM_READ_WRITE, 1000);
        a.input.indices = {short_buffer(), 0};
    });
    expect_refused({"the vertices", "needs 3600 bytes"}, [&](Arguments& a) {
        a.input.indices = {};
        a.input.vertices = {read_only(), (1 << 20) - 100};
    });
    builder.enqueue(sound.queue, sound.input, sound.scratch, sound.result);
    queue.finish();
    CHECK(same_bytes(tree.read(), tree_of_builder(builder, mesh)));
}

TEST_CASE("device builder: the buffers may be sub-buffers, and parts of one buffer") {
    const Mesh mesh = random_triangles(2000);
    for_each_device_builder([&](DeviceBuilder& builder) {
        const Bvh expected = tree_of_builder(builder, mesh);
        for (const Placement placement : {Placement::parts_of_one_buffer, Placement::sub_buffers}) {
            DeviceTree tree(builder, input_layouts().front(), mesh, placement);
            tree.enqueue();
            CHECK(same_bytes(tree.read(), expected));
            CHECK(tree.guards_are_whole());
        }
    });
}

TEST_CASE("device builder: equal boxes and chains need no more than enqueue() gives them") {
    Mesh equal;
    equal.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 1}};
    equal.triangles.assign(20000, {0, 1, 2});
    Mesh chain;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const auto x = static_cast<float>(i) * static_cast<float>(i);
        for (const Vec3& corner : {Vec3{x, 0, 0}, Vec3{x, 1, 0}, Vec3{x, 0, 1}})
            chain.vertices.push_back(corner);
        chain.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    for_each_device_builder([&](DeviceBuilder& builder) {
        for (const Mesh& mesh : {equal, chain}) {
            DeviceTree tree(builder, input_layouts().front(), mesh);
            tree.enqueue();
            CHECK(same_bytes(tree.read(), tree_of_builder(builder, mesh)));
        }
    });
}

TEST_CASE("device builder: it can be moved, and says what it is") {
    DeviceBuilder first = make_device_builder("plocpp-two-level", options_of(Shape::group));
    CHECK(first.info().id == "plocpp-two-level");
    CHECK(first.shape() == Shape::group);
    CHECK(first.options().ploc.range_count == 8);
    CHECK(first.context().opencl_queue() == shared_context().opencl_queue());
    CHECK(first.alignment() > 0);
    DeviceBuilder second = std::move(first);
    const Mesh mesh = random_triangles(500);
    DeviceTree tree(second, input_layouts().front(), mesh);
    tree.enqueue();
    CHECK(same_bytes(tree.read(), tree_of_builder(second, mesh)));
}
