// Profiles: what a file says, which file is used, and that options win, devices are respected and trees stay.
#include "clbvh/device/profile.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>

#include "device/build/stage_bench.hpp"
#include "io/temp_folder.hpp"
#include "support/builders.hpp"
#include "support/environment_variable.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::BuildSettings;
using device::Session;
namespace fs = std::filesystem;

namespace {

Profile profile_of(const DeviceInfo& device) {
    Profile profile{device.platform, device.name, device.driver_version};
    profile.sort_shape = Shape::group;
    profile.chunk_size = 192;
    profile.work_group_size = 128;
    profile.single_group_threshold = 1000;
    profile.hand_over = HandOver::within_launch;
    return profile;
}

Profile real_profile() {
    return profile_of(shared_context().device());
}

/// A folder for profiles, with CLBVH_PROFILE unset.
class ProfileFolder {
public:
    /// Writes the device's own file, and returns its path.
    [[nodiscard]] fs::path write(const std::string& text) const {
        const fs::path path = profile_path(shared_context().device());
        fs::create_directories(path.parent_path());
        return folder_.write(path.lexically_relative(folder_.path("")).string(), text);
    }
    [[nodiscard]] std::string write_elsewhere(const std::string& text) const { return folder_.write("mine", text); }

private:
    TempFolder folder_;
    EnvironmentVariable config_{"XDG_CONFIG_HOME", folder_.path("").c_str()};
    EnvironmentVariable named_{"CLBVH_PROFILE", nullptr};
};

BuildSettings resolve(const BuildOptions& options, DeviceInfo info = shared_context().device()) {
    Session session(info);
    return device::resolve_settings(algorithm_of("plocpp"), options, session);
}

BuildOptions in_shape(Shape shape) {
    BuildOptions options;
    options.device.shape = shape;
    return options;
}

/// The text of the real profile with `from` replaced.
std::string changed(const std::string& from, const std::string& to) {
    std::string text = profile_text(real_profile());
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("profile: what is written is read, and what has nothing to say is left out") {
    const Profile profile = real_profile();
    const Profile read = parse_profile(profile_text(profile), "it");
    CHECK(read.platform == profile.platform);
    CHECK(read.device == profile.device);
    CHECK(read.driver_version == profile.driver_version);
    CHECK(read.sort_shape == profile.sort_shape);
    CHECK(read.chunk_size == profile.chunk_size);
    CHECK(read.work_group_size == profile.work_group_size);
    CHECK(read.single_group_threshold == profile.single_group_threshold);
    CHECK(read.hand_over == HandOver::within_launch);
    const Profile commented = parse_profile("# mine\n\n" + profile_text(profile) + "  # chunk_size = 64\r\n", "it");
    CHECK(commented.chunk_size == profile.chunk_size);
    const Profile silent = parse_profile(profile_text({"p", "d", "v"}), "it");
    CHECK(silent.sort_shape == Shape::automatic);
    CHECK(silent.hand_over == HandOver::automatic);
    CHECK(silent.chunk_size + silent.work_group_size + silent.single_group_threshold == 0);
}

TEST_CASE("profile: a text that is no profile is an error that names the file and what is wrong") {
    const auto expect_refused = [](const std::string& text, const std::string& fault) {
        INFO(text);
        expect_error(ErrorCode::invalid_input, {"some file is no profile", fault},
                     [&] { (void)parse_profile(text, "some file"); });
    };
    expect_refused("", "no format");
    const std::string whole = profile_text(real_profile());
    expect_refused(whole.substr(0, whole.find("driver_version")), "no driver_version");
    expect_refused("\n{}\n", "line 2 is not NAME = VALUE");
    expect_refused("= 7", "line 1 is not NAME = VALUE");
    expect_refused(whole + "chunk_size = 64\n", "chunk_size is there twice");
    expect_refused(changed("clbvh-profile", "other"), "format");
    expect_refused(changed("hand_over = within", "hand_over = yes"), "hand_over is not auto, within or between");
    expect_refused(changed("version = 1", "version = 2"), "version");
    expect_refused(changed("driver_version", "driver"), "no driver_version");
    expect_refused(changed("sort_shape = group", "sort_shape = square"), "sort_shape");
    expect_refused(changed("192", "-192"), "chunk_size is not a whole number");
    expect_refused(changed("192", "1e300"), "chunk_size is not a whole number");
    expect_refused(changed("192", "4294967488"), "chunk_size is not a whole number");
    expect_refused(changed("192", "100"), "chunk_size is 100");
    expect_refused(changed("128", "100"), "work_group_size is 100");
    expect_refused(changed("1000", "1"), "single_group_threshold is 1");
}

TEST_CASE("profile: the device's own file is used, and ignored with a reason where it is not for this") {
    const ProfileFolder folder;
    const DeviceInfo& device = shared_context().device();
    CHECK_FALSE(find_profile(device).profile.has_value());
    CHECK(find_profile(device).reason.empty());
    const fs::path path = folder.write(profile_text(real_profile()));
    CHECK(find_profile(device).path == path);
    CHECK(find_profile(device).profile->chunk_size == 192);
    CHECK(Context::open().profile().path == path);
    DeviceInfo updated = device;
    updated.driver_version += "1";
    CHECK(profile_path(updated) != path);
    CHECK_FALSE(find_profile(updated).profile.has_value());

    const auto expect_ignored = [&](const std::string& text, const std::string& reason) {
        (void)folder.write(text);
        CHECK_FALSE(find_profile(device).profile.has_value());
        CHECK_THAT(find_profile(device).reason, Catch::Contains(reason));
        CHECK_NOTHROW(Context::open());
    };
    expect_ignored("{", "line 1");
    expect_ignored(std::string(100000, ' '), "no profile");
    expect_ignored(changed(device.name, "another device"), "another device");
    expect_ignored(changed(device.platform, "another platform"), "another platform");
    expect_ignored(changed(device.driver_version, "0.1"), "driver version 0.1");
}

TEST_CASE("profile: CLBVH_PROFILE names another file, or none") {
    const ProfileFolder folder;
    (void)folder.write(profile_text(real_profile()));
    const DeviceInfo& device = shared_context().device();
    {
        const std::string mine = folder.write_elsewhere(changed("192", "256"));
        const EnvironmentVariable named("CLBVH_PROFILE", mine.c_str());
        CHECK(find_profile(device).profile->chunk_size == 256);
        CHECK(Context::open().profile().path == mine);
        (void)folder.write_elsewhere(changed(device.driver_version, "0.1"));
        CHECK_FALSE(find_profile(device).profile.has_value());
        CHECK_THAT(find_profile(device).reason, Catch::Contains("driver version 0.1"));
        (void)folder.write_elsewhere("nonsense");
        expect_error(ErrorCode::invalid_input, {"CLBVH_PROFILE", mine, "NAME = VALUE"}, [] { (void)Context::open(); });
        CHECK_NOTHROW(Context::open({}, {ProgramCaching::automatic, false}));
    }
    {
        const std::string file = folder.write_elsewhere("") + "-missing";
        const EnvironmentVariable missing("CLBVH_PROFILE", file.c_str());
        expect_error(ErrorCode::io, {"CLBVH_PROFILE", file}, [] { (void)Context::open(); });
    }
    {
        // Opening it would wait for a writer that never comes.
        const std::string pipe = folder.write_elsewhere("");
        fs::remove(pipe);
        REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
        const EnvironmentVariable named("CLBVH_PROFILE", pipe.c_str());
        expect_error(ErrorCode::invalid_input, {"CLBVH_PROFILE", pipe, "no profile"}, [] { (void)Context::open(); });
    }
    const EnvironmentVariable off("CLBVH_PROFILE", "off");
    CHECK_FALSE(find_profile(device).profile.has_value());
    CHECK(find_profile(device).path.empty());
}

TEST_CASE("profile: it stands in for automatic options, and given ones win") {
    const ProfileFolder folder;
    const BuildSettings lane_before = resolve(in_shape(Shape::lane));
    const BuildSettings group_before = resolve(in_shape(Shape::group));
    (void)folder.write(profile_text(real_profile()));
    CHECK(resolve(in_shape(Shape::lane)).lane_chunk_size == 192);
    CHECK(resolve(in_shape(Shape::lane)).sort_shape == Shape::group);
    CHECK(resolve(in_shape(Shape::lane)).single_group_threshold == 1000);
    CHECK(resolve(in_shape(Shape::group)).cluster_group_size == 128);
    CHECK(resolve(in_shape(Shape::group)).range_count == group_before.range_count);

    BuildOptions given = in_shape(Shape::lane);
    given.ploc.chunk_size = 448;
    given.device.sort_shape = Shape::lane;
    given.ploc.single_group_threshold = 2000;
    CHECK(resolve(given).lane_chunk_size == 448);
    CHECK(resolve(given).sort_shape == Shape::lane);
    CHECK(resolve(given).single_group_threshold == 2000);
    given = in_shape(Shape::group);
    given.ploc.work_group_size = 256;
    CHECK(resolve(given).cluster_group_size == 256);

    Session without(shared_context().device(), {ProgramCaching::automatic, false});
    CHECK(device::resolve_settings(algorithm_of("plocpp"), in_shape(Shape::lane), without).lane_chunk_size ==
          lane_before.lane_chunk_size);
}

TEST_CASE("profile: what does not fit the device or the radius gives way to the default") {
    const ProfileFolder folder;
    DeviceInfo small = shared_context().device();
    small.local_memory_bytes = 64 << 10;
    BuildOptions group = in_shape(Shape::group);
    group.ploc.search_radius = 32;
    BuildOptions lane = in_shape(Shape::lane);
    const BuildSettings group_before = resolve(group, small);
    const BuildSettings lane_before = resolve(lane, small);
    Profile profile = real_profile();
    profile.chunk_size = 4096;
    (void)folder.write(profile_text(profile));
    CHECK(resolve(group, small).cluster_group_size == group_before.cluster_group_size);
    CHECK(resolve(lane, small).lane_chunk_size == lane_before.lane_chunk_size);
    CHECK(resolve(lane).lane_chunk_size == 4096);
}

TEST_CASE("profile: the tree is the same with it") {
    const ProfileFolder folder;
    const Mesh mesh = random_triangles(5000);
    (void)folder.write(profile_text(real_profile()));
    const Context context = Context::open();
    REQUIRE(context.profile().profile.has_value());
    for (const Shape shape : {Shape::lane, Shape::group}) {
        INFO(to_string(shape));
        const Bvh before = make_builder("plocpp", in_shape(shape)).build(mesh);
        CHECK(same_bytes(Builder("plocpp", context, in_shape(shape)).build(mesh), before));
    }
}
