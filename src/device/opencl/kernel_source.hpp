#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace clbvh::device {

/// One file of kernels/, embedded by the build.
struct KernelFile {
    const char* name;  ///< without a folder: no two are alike
    const char* path;  ///< from the project's root on
    const char* text;
};
extern const KernelFile kKernelFiles[];
extern const std::size_t kKernelFileCount;

/// Where kernel file `name` is, from the project's root on. Throws Error(unsupported) as kernel_source().
[[nodiscard]] std::string_view kernel_path(std::string_view name);

/// The text of kernel file `name` with its #include lines replaced by the files they name, each once; #line directives
/// say what comes from where. Throws Error(unsupported) for a file that the library does not hold.
[[nodiscard]] std::string kernel_source(std::string_view name);

/// The same for several files as one program, which share what they include.
[[nodiscard]] std::string kernel_source(std::span<const std::string_view> names);

}  // namespace clbvh::device
