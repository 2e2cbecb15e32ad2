#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "clbvh/core/error.hpp"

namespace clbvh {

/// Throws Error(invalid_input) where the array called `name` has not as many elements as there are rays.
inline void check_length(std::string_view name, std::size_t length, std::size_t rays) {
    if (length == rays) return;
    throw Error(ErrorCode::invalid_input, std::string(name) + " has room for " + std::to_string(length) +
                                              " rays, but there are " + std::to_string(rays) + "; it must be as many");
}

}  // namespace clbvh
