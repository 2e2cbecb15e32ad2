#include "device/opencl/kernel_source.hpp"

#include <algorithm>
#include <set>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

constexpr std::string_view kInclude = "#include \"";

const KernelFile& file_of(std::string_view name) {
    const std::span files(kKernelFiles, kKernelFileCount);
    const auto file = std::ranges::find(files, name, [](const KernelFile& f) { return std::string_view(f.name); });
    if (file == files.end()) {
        throw Error(ErrorCode::unsupported, "this build of libclbvh holds no kernel file '" + std::string(name) + "'");
    }
    return *file;
}

/// Tells compilers that `line` of the file follows, so that they name it.
void append_place(const KernelFile& file, std::size_t line, std::string& out) {
    out += "#line " + std::to_string(line) + " \"" + file.path + "\"\n";
}

void append_expanded(const KernelFile& file, std::set<std::string_view>& included, std::string& out) {
    append_place(file, 1, out);
    std::string_view rest = file.text;
    for (std::size_t number = 1; !rest.empty(); ++number) {
        const std::size_t line_length = std::min(rest.find('\n'), rest.size() - 1) + 1;
        const std::string_view line = rest.substr(0, line_length);
        rest.remove_prefix(line_length);
        if (!line.starts_with(kInclude)) {
            out += line;
            continue;
        }
        const std::string_view name = line.substr(kInclude.size(), line.find('"', kInclude.size()) - kInclude.size());
        if (included.insert(name).second) append_expanded(file_of(name), included, out);
        append_place(file, number + 1, out);
    }
}

}  // namespace

std::string_view kernel_path(std::string_view name) {
    return file_of(name).path;
}

std::string kernel_source(std::string_view name) {
    return kernel_source(std::span(&name, 1));
}

std::string kernel_source(std::span<const std::string_view> names) {
    std::string source;
    std::set<std::string_view> included;
    for (const std::string_view name : names)
        append_expanded(file_of(name), included, source);
    return source;
}

}  // namespace clbvh::device
