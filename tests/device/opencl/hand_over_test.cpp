// What work groups hand over to each other: the self-test, who decides how it is done, and the same trees either way.
#include "clbvh/device/hand_over.hpp"

#include <catch2/catch.hpp>

#include "clbvh/device/context.hpp"
#include "clbvh/device/profile.hpp"
#include "clbvh/io/scene.hpp"
#include "device/opencl/hand_over_check.hpp"
#include "io/temp_folder.hpp"
#include "support/builders.hpp"
#include "support/environment_variable.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::Session;

namespace {

/// Launches that find what is wrong, where words are held back or lost at every meeting.
constexpr std::uint32_t kFewLaunches = 2;

Context context_with(HandOver hand_over) {
    ContextOptions options;
    options.hand_over = hand_over;
    return Context::open({}, options);
}

HandOver chosen(const ContextOptions& options = {}) {
    return Session(shared_context().device(), options).hand_over();
}

std::string profile_with(HandOver hand_over) {
    const DeviceInfo& device = shared_context().device();
    Profile profile{device.platform, device.name, device.driver_version};
    profile.hand_over = hand_over;
    return profile_text(profile);
}

std::uint32_t launches_of(const Context& context, std::string_view id, const BuildOptions& options, const Mesh& mesh,
                          Bvh& tree) {
    BuildStats stats;
    tree = Builder(id, context, options).build(mesh, &stats);
    return static_cast<std::uint32_t>(stats.launches);
}

}  // namespace

TEST_CASE("hand over: this device passes the self-test, and fails where a word is not sent") {
    Session& session = shared_context().session();
    CHECK(device::hand_over_passes_check(session, kFewLaunches));
    CHECK_FALSE(device::hand_over_passes_check(session, kFewLaunches, " -D HAND_OVER_PUBLISHED=5"));
    CHECK_FALSE(device::hand_over_passes_check(session, kFewLaunches, " -D HAND_OVER_PUBLISHED=not_a_number"));
}

TEST_CASE("hand over: processors need no self-test, others do") {
    const EnvironmentVariable variable("CLBVH_HAND_OVER", nullptr);
    DeviceInfo info = shared_context().device();
    info.type = DeviceType::cpu;
    Session processor(info);
    CHECK(processor.hand_over() == HandOver::within_launch);
    CHECK(processor.program_count() == 0);
    info.type = DeviceType::gpu;
    Session gpu(info);
    CHECK(gpu.program_count() == 0);
    CHECK(gpu.hand_over() == HandOver::within_launch);
    CHECK(gpu.program_count() == 1);
    CHECK(gpu.hand_over() == HandOver::within_launch);
    CHECK(gpu.program_count() == 1);
}

TEST_CASE("hand over: options win over the variable, that over the profile") {
    const TempFolder folder;
    const std::string path = folder.write("profile", profile_with(HandOver::between_launches));
    const EnvironmentVariable profile("CLBVH_PROFILE", path.c_str());
    ContextOptions options;
    {
        const EnvironmentVariable variable("CLBVH_HAND_OVER", nullptr);
        CHECK(chosen() == HandOver::between_launches);
        options.use_profile = false;
        CHECK(chosen(options) == HandOver::within_launch);
        options = {};
        options.hand_over = HandOver::within_launch;
        CHECK(chosen(options) == HandOver::within_launch);
    }
    {
        const EnvironmentVariable variable("CLBVH_HAND_OVER", "within");
        CHECK(chosen() == HandOver::within_launch);
        options.hand_over = HandOver::between_launches;
        CHECK(chosen(options) == HandOver::between_launches);
    }
    const EnvironmentVariable variable("CLBVH_HAND_OVER", "auto");
    CHECK(chosen() == HandOver::between_launches);
}

TEST_CASE("hand over: another value of the variable is an error that says what to use") {
    const EnvironmentVariable variable("CLBVH_HAND_OVER", "never");
    expect_error(ErrorCode::invalid_input, {"CLBVH_HAND_OVER", "never", "auto, within or between"},
                 [] { (void)Context::open(); });
}

TEST_CASE("hand over: builders make the same tree by many launches, which only those take that climb") {
    const Mesh mesh = generate_scene("city", 3000);
    const Context within = context_with(HandOver::within_launch);
    const Context between = context_with(HandOver::between_launches);
    for (const std::string_view id : device_builders()) {
        for (const Shape shape : {Shape::group, Shape::lane}) {
            INFO(id << ", " << to_string(shape));
            Bvh expected, tree;
            const std::uint32_t few = launches_of(within, id, options_of(shape), mesh, expected);
            const std::uint32_t many = launches_of(between, id, options_of(shape), mesh, tree);
            CHECK(same_bytes(tree, expected));
            const bool climbs = (id == "lbvh" || id == "hlbvh" || id == "hploc") && shape == Shape::group;
            CHECK((many > few) == climbs);
        }
    }
}

TEST_CASE("hand over: optimisers make the same tree with one group where boxes meet") {
    const Mesh mesh = generate_scene("city", 3000);
    const auto optimized = [&](HandOver hand_over, Shape shape) {
        BuildOptions options = options_of(shape);
        options.optimizers = "reinsert";
        options.optimize_on = OptimizeOn::device;
        return Builder("lbvh", context_with(hand_over), options).build(mesh);
    };
    const Bvh expected = optimized(HandOver::within_launch, Shape::group);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        INFO(to_string(shape));
        CHECK(same_bytes(optimized(HandOver::between_launches, shape), expected));
    }
}
