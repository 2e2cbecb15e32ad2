#pragma once

#include <filesystem>
#include <string_view>

namespace clbvh::device {

/// The value of a variable of the environment; empty where it is unset.
[[nodiscard]] std::string_view environment(const char* name);

/// The folder clbvh in the user's folder of one kind, as the XDG Base Directory Specification has it: the one that
/// `variable` names where that is absolute, else `default_folder` in HOME. Empty where there is neither.
[[nodiscard]] std::filesystem::path user_folder(const char* variable, std::string_view default_folder);

}  // namespace clbvh::device
