#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/read/gltf_document.hpp"

namespace clbvh::io {

/// The values of an accessor: `count` elements of `components` numbers, one behind the other. Normalised integers are
/// from 0 or -1 to 1; sparse ones are in place.
struct GltfValues {
    std::size_t count = 0, components = 0;
    std::vector<double> numbers;
};

/// Reads accessor `index`, which must be of `type`, such as "VEC3"; `from` says who refers to it. Throws Error(io) with
/// the place.
[[nodiscard]] GltfValues read_accessor(const GltfDocument& document, std::uint64_t index, const char* type,
                                       const std::string& from);

}  // namespace clbvh::io
