#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace clbvh::device {

/// One file of kernels/, embedded by the build.
struct KernelFile {
    const char* name;
    const char* text;
};
extern const KernelFile kKernelFiles[];
extern const std::size_t kKernelFileCount;

/// The text of kernel file `name` with its #include lines replaced by the files they name, each once.
/// Throws Error(unsupported) for a file that the library does not hold.
[[nodiscard]] std::string kernel_source(std::string_view name);

/// The same for several files as one program, which share what they include.
[[nodiscard]] std::string kernel_source(std::span<const std::string_view> names);

}  // namespace clbvh::device
