#pragma once

#include <functional>
#include <initializer_list>
#include <string>

#include "clbvh/core/error.hpp"

namespace clbvh::test {

/// Checks that `action` throws an Error of this code whose message contains all `parts`.
void expect_error(ErrorCode code, std::initializer_list<std::string> parts, const std::function<void()>& action);

}  // namespace clbvh::test
