// Resolution of the options of a chain of optimisers on one device: the shape that its local memory is enough for.
#include "device/tree/optimize.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::OptimizerChain;
using device::Session;

namespace {

OptimizerChain make_chain(Session& on, Shape shape, std::uint32_t treelet_leaves) {
    DeviceOptimizerOptions options;
    options.shape = shape;
    options.treelet_leaves = treelet_leaves;
    return {on, {{"reinsert", &device::kReinsert}, {"treelet", &device::kTreelet}}, options};
}

/// This machine's device, said to have so much local memory.
Session session_with_local_memory(std::uint64_t bytes) {
    DeviceInfo info = shared_context().session().info();
    info.local_memory_bytes = bytes;
    return Session(info);
}

}  // namespace

TEST_CASE("optimizers on devices: too little local memory for the lane shape is told, or the group shape taken") {
    Session small = session_with_local_memory(48 << 10);
    expect_error(ErrorCode::unsupported,
                 {"treelet_leaves 8", "53376 bytes", "49152", "take treelet_leaves 7 or Shape::group"},
                 [&] { static_cast<void>(make_chain(small, Shape::lane, 8)); });
    CHECK(make_chain(small, Shape::automatic, 8).settings().shape == Shape::group);
    CHECK(make_chain(small, Shape::group, 8).settings().shape == Shape::group);
    CHECK(make_chain(small, Shape::lane, 7).settings().shape == Shape::lane);
    Session large = session_with_local_memory(53376);
    CHECK(make_chain(large, Shape::lane, 8).settings().shape == Shape::lane);
    const Shape usual = make_chain(large, Shape::automatic, 7).settings().shape;
    CHECK(make_chain(large, Shape::automatic, 8).settings().shape == usual);
}

TEST_CASE("optimizers on devices: restructuring needs the local memory that is asked for, and no more") {
    Session& on = shared_context().session();
    for (std::uint32_t leaves = 3; leaves <= 8; ++leaves) {
        INFO(leaves << " leaves");
        const OptimizerChain chain = make_chain(on, Shape::lane, leaves);
        const device::ProgramSpec program = device::kTreelet.programs(chain.settings()).back();
        const cl::Kernel& kernel = on.kernel(program, "restructure").kernel;
        const auto device = on.queue().getInfo<CL_QUEUE_DEVICE>();
        const auto used = kernel.getWorkGroupInfo<CL_KERNEL_LOCAL_MEM_SIZE>(device);
        if (used == 0) {
            WARN("SKIPPED: the device does not say what local memory kernels need");
            return;
        }
        CHECK(used == device::kTreelet.lane_local_bytes(chain.settings()));
    }
}
