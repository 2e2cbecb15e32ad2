#include "device/opencl/user_folder.hpp"

#include <cstdlib>

namespace clbvh::device {

std::string_view environment(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? std::string_view{} : value;
}

std::filesystem::path user_folder(const char* variable, std::string_view default_folder) {
    using std::filesystem::path;
    if (const path base = environment(variable); base.is_absolute()) return base / "clbvh";
    if (const path home = environment("HOME"); home.is_absolute()) return home / default_folder / "clbvh";
    return {};
}

}  // namespace clbvh::device
