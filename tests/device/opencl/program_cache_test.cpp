// Programs between processes: what is kept, where, and that whatever lies there, kernels are built and right.
#include "device/opencl/program_cache.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <vector>

#include "device/opencl/kernel_source.hpp"
#include "device/opencl/session.hpp"
#include "io/temp_folder.hpp"
#include "support/builders.hpp"
#include "support/environment_variable.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::ProgramStore;
using device::Session;
namespace fs = std::filesystem;

namespace {

constexpr ContextOptions kOn{ProgramCaching::on};
constexpr const char* kFile = "root.cl";
constexpr const char* kOptions = "-cl-std=CL1.2 -D WORK_GROUP_SIZE=1";

DeviceInfo real_device() {
    return shared_context().device();
}

DeviceInfo on_platform(const std::string& platform) {
    DeviceInfo info = real_device();
    info.platform = platform;
    return info;
}

/// A cache folder for one test, which CLBVH_CACHE_DIR names.
class CacheFolder {
public:
    [[nodiscard]] fs::path path() const { return folder_.path("cache"); }
    [[nodiscard]] std::size_t file_count() const {
        if (!fs::exists(path())) return 0;
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path()), fs::directory_iterator()));
    }
    /// The key of kFile on the real device.
    [[nodiscard]] std::string key() const {
        return device::ProgramCache(real_device(), ProgramStore(path())).key_of(device::kernel_source(kFile), kOptions);
    }
    [[nodiscard]] ProgramStore store() const { return ProgramStore(path()); }

private:
    TempFolder folder_;
    EnvironmentVariable variable_{"CLBVH_CACHE_DIR", folder_.path("cache").c_str()};
};

/// The kernel of kFile in a new session, and whether it came from a binary: such a program has no source.
bool comes_from_binary(const ContextOptions& options) {
    Session session(real_device(), options);
    const device::Kernel& kernel = session.kernel(kFile, "write_root", 1, "");
    return kernel.kernel.getInfo<CL_KERNEL_PROGRAM>().getInfo<CL_PROGRAM_SOURCE>().empty();
}

/// Checks that kFile is built from source now, and loaded the next time.
void expect_mended(const CacheFolder& folder) {
    CHECK_FALSE(comes_from_binary(kOn));
    CHECK(comes_from_binary(kOn));
    CHECK(folder.file_count() == 1);
}

bool is_kept(const DeviceInfo& info, ProgramCaching caching) {
    return device::program_store_for(info, caching).has_value();
}

}  // namespace

TEST_CASE("program cache: kept unless the driver keeps programs itself, the variable or the caller says so") {
    const CacheFolder folder;
    const DeviceInfo pocl = on_platform("Portable Computing Language");
    const DeviceInfo nvidia = on_platform("NVIDIA CUDA");
    const DeviceInfo intel = on_platform("Intel(R) OpenCL");
    for (const char* const value : {static_cast<const char*>(nullptr), "", "auto"}) {
        const EnvironmentVariable variable("CLBVH_CACHE", value);
        CHECK_FALSE(is_kept(pocl, ProgramCaching::automatic));
        CHECK_FALSE(is_kept(nvidia, ProgramCaching::automatic));
        CHECK(is_kept(intel, ProgramCaching::automatic));
    }
    for (const bool on : {true, false}) {
        const EnvironmentVariable variable("CLBVH_CACHE", on ? "on" : "off");
        for (const DeviceInfo& info : {pocl, nvidia, intel}) {
            CHECK(is_kept(info, ProgramCaching::automatic) == on);
            CHECK(is_kept(info, ProgramCaching::on));
            CHECK_FALSE(is_kept(info, ProgramCaching::off));
        }
    }
    const EnvironmentVariable wrong("CLBVH_CACHE", "yes");
    expect_error(ErrorCode::invalid_input, {"CLBVH_CACHE", "'yes'", "auto, on or off"}, [&] { (void)Context::open(); });
    CHECK(is_kept(pocl, ProgramCaching::on));
}

TEST_CASE("program cache: the folder is CLBVH_CACHE_DIR, else below XDG_CACHE_HOME, else below HOME") {
    const EnvironmentVariable home("HOME", "/home/someone");
    const EnvironmentVariable xdg("XDG_CACHE_HOME", "/caches");
    const EnvironmentVariable own("CLBVH_CACHE_DIR", "some/folder");
    CHECK(device::cache_folder() == "some/folder");
    const EnvironmentVariable empty_own("CLBVH_CACHE_DIR", "");
    CHECK(device::cache_folder() == "/caches/clbvh");
    for (const char* const unusable : {static_cast<const char*>(nullptr), "", "relative"}) {
        const EnvironmentVariable no_xdg("XDG_CACHE_HOME", unusable);
        CHECK(device::cache_folder() == "/home/someone/.cache/clbvh");
        const EnvironmentVariable no_home("HOME", unusable);
        CHECK(device::cache_folder().empty());
        CHECK_FALSE(is_kept(real_device(), ProgramCaching::on));
    }
}

TEST_CASE("program cache: the key names all that a binary depends on") {
    const DeviceInfo info = real_device();
    std::vector<DeviceInfo> devices(6, info);
    devices[1].platform += "x";
    devices[2].vendor += "x";
    devices[3].name += "x";
    devices[4].version += "x";
    devices[5].driver_version += "x";
    std::vector<std::string> keys;
    for (const DeviceInfo& device : devices) {
        const device::ProgramCache cache(device, ProgramStore("unused"));
        for (const char* const source : {"kernel void a() {}", "kernel void b() {}"}) {
            keys.push_back(cache.key_of(source, "-D A=1"));
            keys.push_back(cache.key_of(source, "-D A=2"));
        }
    }
    const std::size_t count = keys.size();
    std::sort(keys.begin(), keys.end());
    CHECK(static_cast<std::size_t>(std::unique(keys.begin(), keys.end()) - keys.begin()) == count);
}

TEST_CASE("program cache: the next process loads the binary, and builds the same tree with it") {
    const CacheFolder folder;
    const Mesh mesh = random_triangles(3000);
    const Bvh expected = make_builder("lbvh").build(mesh);
    for (int process = 0; process < 2; ++process) {
        const Context context = Context::open({}, kOn);
        CHECK(same_bytes(Builder("lbvh", context).build(mesh), expected));
    }
    CHECK(folder.file_count() > 0);
    CHECK_FALSE(comes_from_binary({ProgramCaching::off}));
}

TEST_CASE("program cache: off writes nothing and reads nothing") {
    const CacheFolder folder;
    CHECK_FALSE(comes_from_binary({ProgramCaching::off}));
    CHECK(folder.file_count() == 0);
    expect_mended(folder);
    CHECK_FALSE(comes_from_binary({ProgramCaching::off}));
}

TEST_CASE("program cache: a binary that the driver refuses is built again and replaced") {
    const CacheFolder folder;
    folder.store().store(folder.key(), "no binary of any driver");
    expect_mended(folder);
}

TEST_CASE("program cache: a damaged file is built again and replaced") {
    const CacheFolder folder;
    expect_mended(folder);
    const fs::path path = folder.store().path_of(folder.key());
    const std::string whole = content_of(path);
    std::string flipped = whole;
    flipped[whole.size() / 2] = static_cast<char>(~flipped[whole.size() / 2]);
    for (const std::string& content : {flipped, whole.substr(0, whole.size() / 2), std::string("foreign")}) {
        std::ofstream(path, std::ios::binary) << content;
        expect_mended(folder);
    }
}

TEST_CASE("program cache: without a folder to write kernels are built all the same") {
    const EnvironmentVariable nowhere("CLBVH_CACHE_DIR", "/dev/null/cache");
    for (int process = 0; process < 2; ++process)
        CHECK_FALSE(comes_from_binary(kOn));
}

TEST_CASE("program cache: what does not build is not kept") {
    const CacheFolder folder;
    Session session(real_device(), kOn);
    expect_error(ErrorCode::device_failure, {"kernels/cluster/plocpp.cl", "CL_BUILD_PROGRAM_FAILURE"},
                 [&] { (void)session.kernel("plocpp.cl", "finish", 1, " -D SEARCH_RADIUS=not_a_number"); });
    CHECK(folder.file_count() == 0);
}
