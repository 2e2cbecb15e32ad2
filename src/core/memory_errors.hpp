#pragma once

#include <new>
#include <string>
#include <utility>

#include "clbvh/core/error.hpp"

namespace clbvh {

/// Runs `action`; where the host has no memory left for it, throws Error(out_of_memory) naming `what`.
template <typename Action>
decltype(auto) with_memory_errors(const char* what, Action&& action) {
    try {
        return std::forward<Action>(action)();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, std::string("the host has no memory left for ") + what);
    }
}

}  // namespace clbvh
