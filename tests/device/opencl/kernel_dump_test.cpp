// CLBVH_DUMP_KERNELS: what is built is written down, whole, or an error says why not.
#include "device/opencl/kernel_dump.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "device/opencl/kernel_source.hpp"
#include "device/opencl/session.hpp"
#include "io/temp_folder.hpp"
#include "support/builders.hpp"
#include "support/environment_variable.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace fs = std::filesystem;

namespace {

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    if (!fs::exists(folder)) return files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        files.push_back(entry.path());
    return files;
}

std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void build_parents(std::size_t work_group_size, const std::string& options) {
    device::Session session(shared_context().device());
    (void)session.kernel("parents.cl", "find_parents", work_group_size, options);
}

}  // namespace

TEST_CASE("kernel dump: every program that is built is in the folder, with its options, one file each") {
    const TempFolder temporary;
    const fs::path folder = fs::path(temporary.path("of")) / "kernels";
    const EnvironmentVariable variable("CLBVH_DUMP_KERNELS", folder.c_str());
    build_parents(16, "");
    build_parents(16, "");
    REQUIRE(files_in(folder).size() == 1);
    const std::string dumped = text_of(files_in(folder).front());
    CHECK(dumped.ends_with(device::kernel_source("parents.cl")));
    CHECK_THAT(dumped, Catch::Contains("kernels/tree/parents.cl") && Catch::Contains("-D WORK_GROUP_SIZE=16"));
    build_parents(16, " -D WORD=64");
    CHECK(files_in(folder).size() == 2);
}

TEST_CASE("kernel dump: nothing is written without the variable, and a folder that cannot be written is named") {
    const TempFolder temporary;
    {
        const EnvironmentVariable variable("CLBVH_DUMP_KERNELS", nullptr);
        build_parents(8, "");
        CHECK(files_in(temporary.path("")).empty());
    }
    const fs::path file = temporary.path("file");
    std::ofstream(file) << "no folder";
    const EnvironmentVariable variable("CLBVH_DUMP_KERNELS", file.c_str());
    expect_error(ErrorCode::io, {"CLBVH_DUMP_KERNELS", file.string()}, [] { build_parents(8, ""); });
}
