// Refits on the caller's queue, in the caller's memory: behind a build, with nothing allocated and nothing waited for.
#include <catch2/catch.hpp>

#include "clbvh/device/device_refitter.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/device_tree.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"
#include "support/refit_memory.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const device::Session& session() {
    return shared_context().session();
}

cl_command_queue shared_queue() {
    return shared_context().opencl_queue();
}

/// Builds, orders, refits and asks for the cost on one queue, each behind the one before.
void expect_refit_behind_build(DeviceBuilder& builder, const InputLayout& layout, const Mesh& mesh,
                               const cl::CommandQueue& queue, Shape shape) {
    const auto primitives = static_cast<std::uint32_t>(mesh.triangles.size());
    DeviceTree tree(builder, layout, mesh);
    DeviceRefitter refitter = make_refitter(shape);
    const DeviceBvh bvh = DeviceBvh::of(tree.result(), primitives);
    const DeviceRefitSizes sizes = refitter.sizes(bvh.node_count, primitives);
    const cl::Buffer order = filled_buffer(sizes.order), scratch = filled_buffer(sizes.scratch);
    const cl::Buffer rest = filled_buffer(sizes.cost_scratch);
    const cl::Buffer sah = filled_buffer(8), last_cost = filled_buffer(4);
    cl::UserEvent begin(session().context());
    cl_event built = nullptr, ordered = nullptr, refitted = nullptr, rated = nullptr;
    const OpenClCalls calls = opencl_calls_of([&] {
        const cl::Event end = tree.enqueue(queue, {begin()});
        clRetainEvent(end());
        built = end();
        refitter.enqueue_order(queue(), bvh, {order()}, {&built, 1}, &ordered);
        refitter.enqueue(queue(), bvh, {tree.input(), {order()}, {scratch()}, {sah()}}, {&ordered, 1}, &refitted);
        refitter.enqueue_cost(queue(), bvh, {rest()}, {last_cost()}, {&refitted, 1}, &rated);
    });
    CHECK(calls.buffers == 0);
    CHECK(calls.programs == 0);
    CHECK(calls.waits == 0);
    queue.flush();
    const cl::Event owned[] = {cl::Event(built), cl::Event(ordered), cl::Event(refitted), cl::Event(rated)};
    CHECK(owned[3].getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
    begin.setStatus(CL_COMPLETE);
    owned[3].wait();
    const Bvh fitted = tree.read();
    CHECK(same_bytes(fitted, make_builder("hploc").build(mesh)));
    const double cost = sah_cost(fitted);
    expect_costs(read<float>(sah, 2), cost, cost);
    CHECK(read<float>(last_cost, 1)[0] == Approx(cost).epsilon(1e-6));
    CHECK(tree.guards_are_whole());
}

}  // namespace

TEST_CASE("device refitter: a build, an order and refits follow each other on any queue, and nobody waits") {
    Mesh mesh = random_triangles(2000);
    deactivate_triangles(mesh, 5, 9);  // how many nodes there are is known on the device alone
    DeviceBuilder builder("hploc", shared_context());
    for (const cl::CommandQueue& queue : {session().queue(), out_of_order_queue()}) {
        if (queue() == nullptr) {
            WARN("SKIPPED: the device has no queues out of order");
            continue;
        }
        for (const InputLayout& layout : input_layouts()) {
            for (const Shape shape : kBothShapes) {
                INFO(layout.name << ", " << to_string(shape));
                expect_refit_behind_build(builder, layout, mesh, queue, shape);
            }
        }
    }
}

TEST_CASE("device refitter: trees without nodes cost nothing") {
    const Mesh mesh;
    DeviceRefitter refitter(shared_context());
    const RefitMemory memory(refitter, Bvh{}, mesh);
    refitter.enqueue_order(shared_queue(), memory.tree(), memory.order());
    refitter.enqueue(shared_queue(), memory.tree(), memory.refit());
    CHECK(memory.read_sah() == std::vector{0.0f, 0.0f});
    fill_bytes(cl::Buffer(memory.sah().buffer, true), 0x5a);
    refitter.enqueue_cost(shared_queue(), memory.tree(), memory.scratch(), memory.sah());
    CHECK(memory.read_sah()[0] == 0.0f);
    Mesh inactive = random_triangles(20);
    deactivate_triangles(inactive);
    DeviceBuilder builder("hploc", shared_context());
    DeviceTree tree(builder, input_layouts().front(), inactive);
    tree.enqueue();
    for (const Shape shape : kBothShapes) {
        DeviceRefitter shaped = make_refitter(shape);
        const DeviceBvh bvh = DeviceBvh::of(tree.result(), 20);
        const DeviceRefitSizes sizes = shaped.sizes(40, 20);
        const cl::Buffer order = filled_buffer(sizes.order), scratch = filled_buffer(sizes.scratch);
        const Node root = tree.root();
        shaped.enqueue_order(shared_queue(), bvh, {order()});
        shaped.enqueue(shared_queue(), bvh, {tree.input(), {order()}, {scratch()}, memory.sah()});
        CHECK(memory.read_sah() == std::vector{0.0f, 0.0f});
        CHECK(tree.root() == root);
    }
}

TEST_CASE("device refitter: what is wrong with memory of the caller's is named, and nothing is enqueued") {
    const Mesh mesh = random_triangles(100);
    const Bvh tree = make_builder("plocpp").build(mesh);
    DeviceRefitter refitter(shared_context());
    const RefitMemory memory(refitter, tree, mesh);
    const cl::Buffer read_only(session().context(), CL_MEM_READ_ONLY, 1 << 20);
    const auto expect_refused = [&](std::initializer_list<std::string> words, auto&& change) {
        DeviceBvh bvh = memory.tree();
        DeviceRefit refit = memory.refit();
        cl_command_queue queue = shared_queue();
        change(queue, bvh, refit);
        const OpenClCalls calls = opencl_calls_of(
            [&] { expect_error(ErrorCode::invalid_input, words, [&] { refitter.enqueue(queue, bvh, refit); }); });
        CHECK(calls.launches == 0);
    };
    using Tree = DeviceBvh&;
    using Refit = DeviceRefit&;
    using Queue = cl_command_queue&;
    expect_refused({"queue is null"}, [](Queue queue, Tree, Refit) { queue = nullptr; });
    expect_refused({"the nodes", "no buffer"}, [](Queue, Tree given, Refit) { given.nodes = {}; });
    expect_refused({"the nodes", "needs 32000000 bytes"}, [](Queue, Tree given, Refit) { given.node_count = 1000000; });
    expect_refused({"the nodes", "multiple of"}, [](Queue, Tree given, Refit) { given.nodes.offset = 32; });
    expect_refused({"the active count's offset"}, [&](Queue, Tree given, Refit) {
        given.active_count = {read_only(), 2};
    });
    expect_refused({"the active count", "the nodes"},
                   [](Queue, Tree given, Refit) { given.active_count = given.nodes; });
    expect_refused({"the primitive ids", "no buffer"}, [](Queue, Tree given, Refit) { given.primitive_ids = {}; });
    expect_refused({"the primitive ids", "CL_MEM_READ_WRITE"},
                   [&](Queue, Tree given, Refit) { given.primitive_ids = {read_only()}; });
    expect_refused({"the order", "no buffer"}, [](Queue, Tree, Refit r) { r.order = {}; });
    expect_refused({"the order", "needs"}, [](Queue, Tree, Refit r) { r.order.offset = 4096; });
    expect_refused({"the scratch", "needs"}, [](Queue, Tree, Refit r) { r.scratch.offset = 4096; });
    expect_refused({"the order and the scratch overlap"}, [](Queue, Tree, Refit r) { r.order = r.scratch; });
    expect_refused({"the costs' offset"}, [](Queue, Tree, Refit r) { r.sah.offset = 2; });
    expect_refused({"the costs", "CL_MEM_READ_WRITE"}, [&](Queue, Tree, Refit r) { r.sah = {read_only()}; });
    expect_refused({"the vertices", "no buffer"},
                   [](Queue, Tree, Refit r) { std::get<DeviceTriangles>(r.input).vertices = {}; });
    expect_error(ErrorCode::invalid_input, {"the order", "no buffer"},
                 [&] { refitter.enqueue_order(shared_queue(), memory.tree(), {}); });
    expect_error(ErrorCode::invalid_input, {"the scratch", "no buffer"},
                 [&] { refitter.enqueue_cost(shared_queue(), memory.tree(), {}, memory.sah()); });
    expect_error(ErrorCode::invalid_input, {"cost"}, [] {
        static_cast<void>(make_refitter(Shape::automatic, {-1.0, 1.0}));
    });
}
