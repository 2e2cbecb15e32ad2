#pragma once

#include <string>
#include <string_view>

namespace clbvh::device {

/// Writes a program's source, behind a comment that names its files and options, into the folder that the variable
/// CLBVH_DUMP_KERNELS names, which is made where it is not there; does nothing where the variable is not set. The same
/// program goes to the same file. Throws Error(io) naming the folder or the file where it cannot be written.
void dump_kernels(std::string_view files, const std::string& options, const std::string& source);

}  // namespace clbvh::device
