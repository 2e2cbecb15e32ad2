// A device's session: programs built once, failures that say where, and queues that the caller made.
#include "device/opencl/session.hpp"

#include <catch2/catch.hpp>
#include <span>

#include "clbvh/builder.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::Kernel;
using device::Session;

namespace {

cl::Device real_device() {
    return cl::Device(static_cast<cl_device_id>(shared_context().device().id), true);
}

Kernel& number_leaves(Session& session, std::size_t work_group_size, const std::string& options = "") {
    return session.kernel("leaves.cl", "number_leaves", work_group_size, options);
}

/// Builds on an adopted queue and compares with the shared context's tree.
BuildStats expect_same_tree_on(cl_command_queue queue) {
    const Mesh mesh = random_triangles(2000);
    BuildStats stats;
    Builder builder("plocpp", Context::adopt(queue), options_of(Shape::lane));
    CHECK(same_bytes(builder.build(mesh, &stats), make_builder("plocpp", options_of(Shape::lane)).build(mesh)));
    return stats;
}

double device_ms(const BuildStats& stats) {
    double sum = 0.0;
    for (const StageStats& stage : stats.stages)
        sum += stage.device_ms;
    return sum;
}

}  // namespace

TEST_CASE("session: the same kernel is built once, another size or option is another kernel") {
    Session session(shared_context().device());
    Kernel& kernel = number_leaves(session, 1);
    const cl_kernel handle = kernel.kernel();
    CHECK(kernel.name == "number_leaves");
    CHECK(kernel.work_group_size == 1);
    Kernel& gather = session.kernel("leaves.cl", "gather_leaves", 1, "");
    CHECK(gather.kernel() != handle);
    CHECK(gather.kernel.getInfo<CL_KERNEL_PROGRAM>()() == kernel.kernel.getInfo<CL_KERNEL_PROGRAM>()());
    Kernel& group = number_leaves(session, 64);
    CHECK(group.work_group_size == 64);
    CHECK(group.kernel() != handle);
    CHECK(number_leaves(session, 1, " -D WORD=4").kernel() != handle);
    CHECK(&number_leaves(session, 1) == &kernel);
    CHECK(number_leaves(session, 1).kernel() == handle);
}

TEST_CASE("session: a kernel that does not build is an error with its file, options, device and log") {
    Session session(shared_context().device());
    const auto build_broken = [&] { (void)session.kernel("plocpp.cl", "finish", 1, " -D SEARCH_RADIUS=not_a_number"); };
    for (int attempt = 0; attempt < 2; ++attempt) {
        expect_error(ErrorCode::device_failure,
                     {"CL_BUILD_PROGRAM_FAILURE", "kernels/cluster/plocpp.cl",
                      "WORK_GROUP_SIZE=1 -D SEARCH_RADIUS=not_a_number", session.info().name},
                     build_broken);
        try {
            build_broken();
        } catch (const Error& error) {
            const std::string message = error.what();
            const std::size_t log = message.find(":\n");
            REQUIRE(log != std::string::npos);
            CHECK_THAT(message.substr(log), Catch::Contains("not_a_number"));
        }
    }
    CHECK(session.kernel("plocpp.cl", "finish", 1, "").name == "finish");
}

TEST_CASE("session: kernels and files that do not exist are errors that name them") {
    Session session(shared_context().device());
    expect_error(ErrorCode::device_failure, {"no_such_kernel", "kernels/build/leaves.cl", "CL_INVALID_KERNEL_NAME"},
                 [&] { (void)session.kernel("leaves.cl", "no_such_kernel", 1, ""); });
    expect_error(ErrorCode::unsupported, {"no_such_file.cl"},
                 [&] { (void)session.kernel("no_such_file.cl", "number_leaves", 1, ""); });
    CHECK(number_leaves(session, 1).name == "number_leaves");
}

TEST_CASE("session: what was prepared is not built again, and files of a group are one program where that is cheaper") {
    Session session(shared_context().device());
    const device::ProgramSpec root{"root.cl", 1, ""};
    const device::ProgramSpec check{"lane_shape_check.cl", 1, ""};
    const device::ProgramSpec group[] = {root, check, {"leaves.cl", 64, ""}};
    const device::ProgramSpec own{"lbvh.cl", 1, ""};
    const bool joined = session.joins_programs();
    CHECK(joined == (shared_context().device().platform == "Portable Computing Language"));
    session.prepare({group, std::span(&own, 1)});
    CHECK(session.program_count() == (joined ? 3 : 4));
    const auto program_of = [&](const device::ProgramSpec& spec, std::string_view name) {
        return session.kernel(spec, name).kernel.getInfo<CL_KERNEL_PROGRAM>()();
    };
    CHECK((program_of(root, "write_root") == program_of(check, "lane_shape_check")) == joined);
    CHECK(program_of(own, "build_pieces") != program_of(root, "write_root"));
    session.prepare({group});
    CHECK(session.program_count() == (joined ? 3 : 4));
    CHECK(program_of({"root.cl", 64, ""}, "write_root") != program_of(root, "write_root"));
    CHECK(session.program_count() == (joined ? 4 : 5));
}

TEST_CASE("session: a program that does not build keeps none of its group, and names its files") {
    Session session(shared_context().device());
    const device::ProgramSpec group[] = {{"root.cl", 1, " -D SEARCH_RADIUS=not_a_number"},
                                         {"plocpp.cl", 1, " -D SEARCH_RADIUS=not_a_number"}};
    expect_error(ErrorCode::device_failure, {"kernels/cluster/plocpp.cl", "not_a_number"},
                 [&] { session.prepare({group}); });
    CHECK(session.program_count() == 0);
    CHECK(number_leaves(session, 1).name == "number_leaves");
}

TEST_CASE("session: a builder builds its programs when it is made, none when it runs") {
    const Mesh mesh = random_triangles(500);
    for (const std::string_view id : device_builders()) {
        for (const Shape shape : {Shape::automatic, Shape::group, Shape::lane}) {
            INFO(id << ", " << to_string(shape));
            const Context context = Context::open();
            Builder builder(id, context, options_of(shape));
            const std::size_t made = context.session().program_count();
            (void)builder.build(mesh);
            CHECK(context.session().program_count() == made);
            if (context.session().joins_programs()) CHECK(made == (shape == Shape::group ? 3 : 2));
        }
    }
}

TEST_CASE("session: only CPUs prefer the lane shape") {
    DeviceInfo info = shared_context().device();
    info.type = DeviceType::gpu;
    CHECK_FALSE(Session(info).prefers_lane_shape());
    if (shared_context().device().platform != "Portable Computing Language") {
        WARN("SKIPPED: only PoCL is known to pass the self-test of the lane shape");
        return;
    }
    CHECK(Session(shared_context().device()).prefers_lane_shape());
}

TEST_CASE("session: a queue that profiles is adopted with its device and context") {
    const cl::Context context(real_device());
    const cl::CommandQueue queue(context, real_device(), CL_QUEUE_PROFILING_ENABLE);
    const Context adopted = Context::adopt(queue());
    CHECK(adopted.opencl_queue() == queue());
    CHECK(adopted.opencl_context() == context());
    CHECK(adopted.device().id == shared_context().device().id);
    CHECK(adopted.device().index == shared_context().device().index);
    CHECK(adopted.device().name == shared_context().device().name);
    CHECK(adopted.session().profiles());
    CHECK(device_ms(expect_same_tree_on(queue())) > 0.0);
}

TEST_CASE("session: a queue that does not profile builds the same tree without device times") {
    const cl::Context context(real_device());
    const cl::CommandQueue queue(context, real_device());
    CHECK_FALSE(Context::adopt(queue()).session().profiles());
    const BuildStats stats = expect_same_tree_on(queue());
    CHECK(device_ms(stats) == 0.0);
    CHECK(stats.build_ms > 0.0);
    CHECK(stats.launches > 0);
}

TEST_CASE("session: an adopted queue outlives the caller's handles") {
    cl::Context context(real_device());
    cl::CommandQueue queue(context, real_device());
    const Context adopted = Context::adopt(queue());
    context = {};
    queue = {};
    CHECK(expect_same_tree_on(adopted.opencl_queue()).launches > 0);
}

TEST_CASE("session: no queue is refused") {
    expect_error(ErrorCode::invalid_input, {"null"}, [] { (void)Context::adopt(nullptr); });
}

TEST_CASE("session: a queue out of order builds the same tree, with device times where it profiles") {
    const auto supported = real_device().getInfo<CL_DEVICE_QUEUE_PROPERTIES>();
    if ((supported & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE) == 0) {
        WARN("SKIPPED: the device has no queues out of order");
        return;
    }
    const cl::Context context(real_device());
    const cl::CommandQueue plain(context, real_device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    CHECK(device_ms(expect_same_tree_on(plain())) == 0.0);
    const cl::CommandQueue profiling(context, real_device(),
                                     CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE | CL_QUEUE_PROFILING_ENABLE);
    CHECK(device_ms(expect_same_tree_on(profiling())) > 0.0);
}
