// Faulty memory and queues that optimisers on devices must refuse.
#include <catch2/catch.hpp>

#include "clbvh/device/device_optimizer.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/opencl_calls.hpp"
#include "support/tree_on_device.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("device optimizers: what is wrong with the arguments is named, and nothing is enqueued") {
    const Bvh tree = make_builder("lbvh").build(random_triangles(100));
    DeviceOptimizer optimizer("treelet", shared_context());
    const TreeOnDevice on_device(tree, optimizer);
    const cl::CommandQueue& queue = TreeOnDevice::queue();
    const cl::Context other_context(queue.getInfo<CL_QUEUE_DEVICE>());
    const cl::Buffer foreign(other_context, CL_MEM_READ_WRITE, 1 << 20);
    const cl::Buffer read_only(TreeOnDevice::context(), CL_MEM_READ_ONLY, 1 << 20);
    const cl::CommandQueue foreign_queue(other_context, queue.getInfo<CL_QUEUE_DEVICE>());
    struct Arguments {
        cl_command_queue queue;
        DeviceBvh tree;
        DeviceSpan scratch;
        std::vector<cl_event> wait_list;
    };
    const Arguments sound{queue(), on_device.target(), {on_device.scratch()}, {}};
    const auto expect_refused = [&](std::initializer_list<std::string> words, auto&& change) {
        Arguments changed = sound;
        change(changed);
        const OpenClCalls calls = opencl_calls_of([&] {
            expect_error(ErrorCode::invalid_input, words,
                         [&] { optimizer.enqueue(changed.queue, changed.tree, changed.scratch, changed.wait_list); });
        });
        CHECK(calls.launches == 0);
    };
    expect_refused({"queue is null"}, [](Arguments& a) { a.queue = nullptr; });
    expect_refused({"queue", "another OpenCL context"}, [&](Arguments& a) { a.queue = foreign_queue(); });
    expect_refused({"wait list", "null"}, [](Arguments& a) { a.wait_list = {nullptr}; });
    expect_refused({"the nodes", "no buffer"}, [](Arguments& a) { a.tree.nodes = {}; });
    expect_refused({"the nodes", "needs 6432 bytes"}, [](Arguments& a) { ++a.tree.node_count; });
    expect_refused({"the nodes", "another OpenCL context"}, [&](Arguments& a) { a.tree.nodes = {foreign()}; });
    expect_refused({"the nodes", "CL_MEM_READ_WRITE"}, [&](Arguments& a) { a.tree.nodes = {read_only()}; });
    expect_refused({"the scratch", "no buffer"}, [](Arguments& a) { a.scratch = {}; });
    expect_refused({"the scratch", "multiple of"}, [](Arguments& a) {
        static const cl::Buffer large(TreeOnDevice::context(), CL_MEM_READ_WRITE, 1 << 20);
        a.scratch = {large(), 4};
    });
    expect_refused({"the nodes and the scratch overlap"}, [](Arguments& a) {
        static const cl::Buffer large(TreeOnDevice::context(), CL_MEM_READ_WRITE, 1 << 20);
        a.tree.nodes = a.scratch = {large()};
    });
    expect_refused({"the active count's offset is 2"}, [&](Arguments& a) { a.tree.active_count = {read_only(), 2}; });
    expect_refused({"the active count", "needs 4 bytes"}, [&](Arguments& a) {
        a.tree.active_count = {read_only(), 1 << 20};
    });
    expect_refused({"the active count and the nodes lie in one buffer", "sub-buffer"}, [](Arguments& a) {
        static const cl::Buffer large(TreeOnDevice::context(), CL_MEM_READ_WRITE, 1 << 20);
        a.tree.nodes = {large()};
        a.tree.active_count = {large(), 1 << 19};
    });
    expect_refused({"the active count", "CL_MEM_WRITE_ONLY"}, [](Arguments& a) {
        static const cl::Buffer write_only(TreeOnDevice::context(), CL_MEM_WRITE_ONLY, 1 << 20);
        a.tree.active_count = {write_only()};
    });
    optimizer.enqueue(sound.queue, sound.tree, sound.scratch);
    CHECK(on_device.read() == optimizer.optimize(tree).nodes);
    expect_error(ErrorCode::unsupported, {"4294967294 nodes", "too large"},
                 [&] { static_cast<void>(optimizer.scratch_bytes(4294967294u)); });
}

TEST_CASE("device optimizers: memory is looked at even where there is nothing to do") {
    const cl_command_queue queue = TreeOnDevice::queue()();
    const cl::Buffer small(TreeOnDevice::context(), CL_MEM_READ_WRITE, 3 * sizeof(Node));
    const cl::Buffer write_only(TreeOnDevice::context(), CL_MEM_WRITE_ONLY, 4);
    for (const char* const ids : {"treelet", "reinsert", ""}) {
        INFO(ids);
        DeviceOptimizer optimizer(ids, shared_context());
        CHECK(optimizer.scratch_bytes(4) == 0);
        expect_error(ErrorCode::invalid_input, {"the nodes", "no buffer"}, [&] {
            optimizer.enqueue(queue, {{}, 4}, {});
        });
        expect_error(ErrorCode::invalid_input, {"the nodes", "needs 128 bytes"}, [&] {
            optimizer.enqueue(queue, {{small()}, 4}, {});
        });
        expect_error(ErrorCode::invalid_input, {"the active count", "CL_MEM_WRITE_ONLY"}, [&] {
            optimizer.enqueue(queue, {{small()}, 2, {}, 0, {write_only()}}, {});
        });
        const OpenClCalls calls = opencl_calls_of([&] {
            optimizer.enqueue(queue, {{small()}, 2}, {});
            optimizer.enqueue(queue, {}, {});
        });
        CHECK(calls.launches == 0);
    }
}
