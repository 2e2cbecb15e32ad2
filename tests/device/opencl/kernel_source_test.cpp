// The kernel files that the library holds: their includes, and that each compiles alone in both shapes.
#include "device/opencl/kernel_source.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <span>
#include <sstream>
#include <vector>

#include "device/opencl/session.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::span<const device::KernelFile> kernel_files() {
    return {device::kKernelFiles, device::kKernelFileCount};
}

/// The text that the library holds of one file.
std::string_view embedded(std::string_view name) {
    const auto file = std::ranges::find(kernel_files(), name, [](const auto& f) { return std::string_view(f.name); });
    REQUIRE(file != kernel_files().end());
    return file->text;
}

/// Names of the files that hold kernels.
std::vector<std::string> programs() {
    std::vector<std::string> names;
    for (const device::KernelFile& file : kernel_files()) {
        const std::string_view name = file.name;
        if (name.ends_with(".cl")) names.emplace_back(name);
    }
    return names;
}

std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> lines;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        lines.emplace_back(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return lines;
}

bool is_include(const std::string& line) {
    return line.starts_with("#include");
}

/// Those of headers that C++ reads as well name the standard library's, for it alone.
bool is_kernel_include(const std::string& line) {
    return is_include(line) && line.find('"') != std::string::npos;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

struct BuiltProgram {
    cl::Program program;
    std::string log;
};

/// Builds the files as one program with these options, warnings being errors.
BuiltProgram build_together(std::span<const std::string_view> files, const std::string& options) {
    const device::Session& session = shared_context().session();
    const cl::Device device(static_cast<cl_device_id>(session.info().id), true);
    BuiltProgram built{cl::Program(session.context(), device::kernel_source(files)), {}};
    try {
        built.program.build(device, ("-cl-std=CL1.2 -Werror " + options).c_str());
    } catch (const cl::Error& error) {
        built.log = std::string(error.what()) + ": " + built.program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device);
    }
    return built;
}

/// The defaults of a file, not of what it includes: from the names of its sizes to their values.
std::map<std::string, std::string> defaults_of(std::string_view file) {
    std::map<std::string, std::string> defaults;
    std::string optional;
    for (const std::string& line : lines_of(embedded(file))) {
        std::istringstream words(line);
        std::string word, name, value;
        words >> word >> name;
        if (word == "#define" && name == optional && std::getline(words, value)) defaults[name] = value;
        optional = word == "#ifndef" ? name : "";
    }
    return defaults;
}

/// Checks that the file builds, and that its kernels demand work groups of this size.
void expect_kernels(const std::string& file, const std::string& options, std::size_t work_group_size) {
    INFO(file << " with '" << options << "'");
    const std::string_view files[] = {file};
    BuiltProgram built = build_together(files, options);
    CHECK(built.log == "");
    if (!built.log.empty()) return;
    std::vector<cl::Kernel> kernels;
    built.program.createKernels(&kernels);
    CHECK_FALSE(kernels.empty());
    const cl::Device device(static_cast<cl_device_id>(shared_context().session().info().id), true);
    for (const cl::Kernel& kernel : kernels) {
        const auto size = kernel.getWorkGroupInfo<CL_KERNEL_COMPILE_WORK_GROUP_SIZE>(device);
        CHECK(size[0] == work_group_size);
        CHECK(size[1] * size[2] == 1);
    }
}

}  // namespace

TEST_CASE("kernel source: every file is the one that the build embedded, with its includes in place") {
    for (const device::KernelFile& file : kernel_files()) {
        INFO(file.name);
        const std::vector<std::string> expanded = lines_of(device::kernel_source(file.name));
        CHECK(std::ranges::none_of(expanded, is_kernel_include));
        // Its own lines follow each other in their order, whatever stands between them.
        auto at = expanded.begin();
        std::size_t missing = 0;
        for (const std::string& line : lines_of(file.text)) {
            if (is_include(line)) continue;
            at = std::find(at, expanded.end(), line);
            missing += at == expanded.end() ? 1 : 0;
        }
        CHECK(missing == 0);
    }
}

TEST_CASE("kernel source: #line says of every line which file's it is, and which") {
    for (const std::string& program : programs()) {
        INFO(program);
        std::map<std::string, std::vector<std::string>> files;  // by path
        for (const device::KernelFile& file : kernel_files())
            files[file.path] = lines_of(file.text);
        const std::vector<std::string>* file = nullptr;
        std::size_t next = 0;
        std::size_t misplaced = 0;
        for (const std::string& line : lines_of(device::kernel_source(program))) {
            if (line.starts_with("#line ")) {
                std::istringstream words(line.substr(6));
                std::string path;
                words >> next >> path;
                const auto found = files.find(path.substr(1, path.size() - 2));
                REQUIRE(found != files.end());
                file = &found->second;
                continue;
            }
            REQUIRE(file != nullptr);
            misplaced += next > file->size() || (*file)[next - 1] != line ? 1 : 0;
            ++next;
        }
        CHECK(misplaced == 0);
    }
}

TEST_CASE("kernel source: the log of a program that does not build names the file and the line") {
    const std::vector<std::string> lines = lines_of(embedded("node.clh"));
    const auto faulty = std::ranges::find_if(lines, [](const std::string& line) {
        return line.find("static inline uint node_first(") != std::string::npos;
    });
    REQUIRE(faulty != lines.end());
    const std::string_view files[] = {"plocpp.cl"};
    const BuiltProgram built = build_together(files, "-D node_first=!");
    CHECK_THAT(built.log, Catch::Contains("kernels/core/node.clh:" + std::to_string(faulty - lines.begin() + 1) + ":"));
}

TEST_CASE("kernel source: a file that is included twice stands there once, before what needs it") {
    const std::string source = device::kernel_source("plocpp_two_level.cl");
    for (const char* const name : {"work_group.clh", "aabb.clh", "node.clh", "scan.clh", "cluster.clh", "chunk.clh"}) {
        INFO(name);
        const std::string first_line = lines_of(embedded(name)).front();
        CHECK(occurrences(source, first_line) == 1);
        CHECK(source.find(first_line) < source.find("KERNEL void"));
    }
    CHECK(source.find("define BORDER") < source.find(lines_of(embedded("chunk.clh")).front()));
}

TEST_CASE("kernel source: a file that the library does not hold is an error that names it") {
    expect_error(ErrorCode::unsupported, {"no_such.cl"}, [] { (void)device::kernel_source("no_such.cl"); });
    expect_error(ErrorCode::unsupported, {"kernel file"}, [] { (void)device::kernel_source(""); });
}

TEST_CASE("kernel source: each program compiles alone, without a warning, in both shapes") {
    REQUIRE(programs().size() >= 8);
    for (const std::string& file : programs()) {
        expect_kernels(file, "", 256);
        expect_kernels(file, "-D WORK_GROUP_SIZE=256", 256);
        expect_kernels(file, "-D WORK_GROUP_SIZE=1", 1);
    }
}

TEST_CASE("kernel source: the files that every builder uses can be one program") {
    const std::string_view files[] = {"bounds.cl", "morton.cl", "radix_sort.cl",
                                      "root.cl",   "leaves.cl", "lane_shape_check.cl"};
    for (const char* const options : {"-D WORK_GROUP_SIZE=1", "-D WORK_GROUP_SIZE=256"})
        CHECK(build_together(files, options).log == "");
    // Where two files have a size of the same name, the first one's default is that of both.
    std::map<std::string, std::string> seen;
    for (const std::string_view file : files) {
        for (const auto& [name, value] : defaults_of(file)) {
            INFO(name << " of " << file);
            CHECK(seen.emplace(name, value).first->second == value);
        }
    }
    CHECK(seen.size() >= 3);
}
