#include "support/expect_error.hpp"

#include <catch2/catch.hpp>

namespace clbvh::test {

void expect_error(ErrorCode code, std::initializer_list<std::string> parts, const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        CHECK(to_string(error.code()) == to_string(code));
        for (const std::string& part : parts)
            CHECK_THAT(error.what(), Catch::Contains(part));
        return;
    }
    FAIL_CHECK("no Error(" << to_string(code) << ") was thrown");
}

}  // namespace clbvh::test
