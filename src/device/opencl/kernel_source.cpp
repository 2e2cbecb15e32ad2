#include "device/opencl/kernel_source.hpp"

#include <algorithm>
#include <set>

#include "clbvh/core/error.hpp"

namespace clbvh::device {
namespace {

constexpr std::string_view kInclude = "#include \"";

std::string_view text_of(std::string_view name) {
    const std::span files(kKernelFiles, kKernelFileCount);
    const auto file = std::ranges::find(files, name, [](const KernelFile& f) { return std::string_view(f.name); });
    if (file == files.end()) {
        throw Error(ErrorCode::unsupported, "this build of libclbvh holds no kernel file '" + std::string(name) + "'");
    }
    return file->text;
}

void append_expanded(std::string_view name, std::set<std::string_view>& included, std::string& out) {
    std::string_view rest = text_of(name);
    while (!rest.empty()) {
        const std::size_t line_length = std::min(rest.find('\n'), rest.size() - 1) + 1;
        const std::string_view line = rest.substr(0, line_length);
        rest.remove_prefix(line_length);
        if (!line.starts_with(kInclude)) {
            out += line;
            continue;
        }
        const std::string_view file = line.substr(kInclude.size(), line.find('"', kInclude.size()) - kInclude.size());
        if (included.insert(file).second) {
            append_expanded(file, included, out);
        }
    }
}

}  // namespace

std::string kernel_source(std::string_view name) {
    return kernel_source(std::span(&name, 1));
}

std::string kernel_source(std::span<const std::string_view> names) {
    std::string source;
    std::set<std::string_view> included;
    for (const std::string_view name : names)
        append_expanded(name, included, source);
    return source;
}

}  // namespace clbvh::device
