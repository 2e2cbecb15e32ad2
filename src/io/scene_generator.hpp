#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clbvh::io {

/// The parameter that the generator of this name takes unless told; empty where it has none, or there is no such one.
[[nodiscard]] std::string standard_parameter(std::string_view generator);

/// What is wrong with the scene `name` (a generator's, or NAME:PARAMETER) of `count` triangles; empty where nothing is.
[[nodiscard]] std::string fault_of_scene(std::string_view name, std::uint64_t count);

}  // namespace clbvh::io
