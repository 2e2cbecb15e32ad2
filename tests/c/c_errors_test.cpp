// Failures behind the C interface: whatever is thrown becomes a code and a message, and the calling program goes on.

#include <catch2/catch.hpp>
#include <new>
#include <stdexcept>
#include <string>

#include "c/guarded.hpp"
#include "clbvh/clbvh.h"
#include "clbvh/core/error.hpp"
#include "clbvh/io/scene.hpp"
#include "support/allocations.hpp"

using clbvh::test::allow_allocations;
using clbvh::test::allow_only_allocations;

namespace {

/// Does `work` with `allowed` allocations left, and none behind them.
template <typename Work>
auto with_allocations(long allowed, const Work& work) {
    allow_only_allocations(allowed);
    const auto result = work();
    allow_allocations(-1);
    return result;
}

int throw_a_number(void*, const char*, double) {
    throw 42;
}

int throw_a_range_error(void*, const char*, double) {
    throw std::range_error("thrown by the callback");
}

}  // namespace

// The table is made once: nothing fails in a process where another test has asked for it already.
TEST_CASE("the C interface's table of options needs memory, and says so where there is none") {
    long allowed = 0;
    while (with_allocations(allowed, [] { return clbvh_option_count(); }) == 0) {
        REQUIRE(std::string(clbvh_last_error()).find("memory") != std::string::npos);
        ++allowed;
    }
    CHECK(clbvh_option_count() > 0);
    allowed = 0;
    while (with_allocations(allowed, [] { return clbvh_option_info(0); }) == nullptr)
        ++allowed;
    CHECK(clbvh_option_info(0) != nullptr);
}

TEST_CASE("memory that runs out for good is a code of the C interface, wherever it does") {
    const clbvh::Mesh mesh = clbvh::generate_scene("hair", 200);
    const auto build_once = [&] {
        clbvh_builder* builder = nullptr;
        clbvh_error result = clbvh_create_builder("binned-sah", nullptr, &builder);
        if (result == CLBVH_OK) result = clbvh_set_option(builder, "thread_count", "1");
        if (result == CLBVH_OK)
            result = clbvh_build(builder, &mesh.vertices.data()->x, mesh.vertices.size(), mesh.triangles.data()->data(),
                                 mesh.triangles.size());
        if (result == CLBVH_OK) result = clbvh_optimize(builder, "rotate", nullptr, nullptr);
        clbvh_destroy_builder(builder);
        return result;
    };
    // oneTBB waits for ever where memory runs out while it starts, so it starts before.
    REQUIRE(build_once() == CLBVH_OK);
    long allowed = 0;
    for (;; ++allowed) {
        INFO("allocation " << allowed);
        const clbvh_error result = with_allocations(allowed, build_once);
        if (result == CLBVH_OK) break;
        REQUIRE(result == CLBVH_OUT_OF_MEMORY);
        REQUIRE(std::string(clbvh_last_error()).find("memory") != std::string::npos);
    }
    CHECK(allowed > 10);
}

TEST_CASE("a message that does not fit is cut, without asking for memory") {
    const std::string name(100000, 'x');
    clbvh_builder* builder = nullptr;
    REQUIRE(clbvh_create_builder(name.c_str(), nullptr, &builder) == CLBVH_INVALID_INPUT);
    const std::string message = clbvh_last_error();
    CHECK(message.size() == clbvh::c::kMessageBytes - 1);
    CHECK(message.ends_with("xxx"));
    // The next one is not mixed with it.
    REQUIRE(clbvh_create_builder(nullptr, nullptr, &builder) == CLBVH_INVALID_INPUT);
    CHECK(std::string(clbvh_last_error()) == "id is null");
}

TEST_CASE("exceptions of every kind become codes of the C interface") {
    const auto code_of = [](auto&& body) { return clbvh::c::guarded(body); };
    CHECK(code_of([] {}) == CLBVH_OK);
    CHECK(code_of([] { throw clbvh::Error(clbvh::ErrorCode::io, "a file"); }) == CLBVH_IO);
    CHECK(std::string(clbvh_last_error()) == "a file");
    CHECK(code_of([] { throw std::bad_alloc(); }) == CLBVH_OUT_OF_MEMORY);
    CHECK(code_of([] { throw std::logic_error("a fault"); }) == CLBVH_INTERNAL);
    CHECK(std::string(clbvh_last_error()) == "a fault");
    CHECK(code_of([] { throw 1; }) == CLBVH_INTERNAL);
    CHECK(std::string(clbvh_last_error()).find("unknown") != std::string::npos);
}

TEST_CASE("what a callback throws ends in a code of the C interface") {
    const clbvh::Mesh mesh = clbvh::generate_scene("soup", 100);
    clbvh_builder* builder = nullptr;
    REQUIRE(clbvh_create_builder("median", nullptr, &builder) == CLBVH_OK);
    const auto build = [&] {
        return clbvh_build(builder, &mesh.vertices.data()->x, mesh.vertices.size(), mesh.triangles.data()->data(),
                           mesh.triangles.size());
    };
    REQUIRE(clbvh_set_progress(builder, throw_a_number, nullptr) == CLBVH_OK);
    CHECK(build() == CLBVH_INTERNAL);
    REQUIRE(clbvh_set_progress(builder, throw_a_range_error, nullptr) == CLBVH_OK);
    CHECK(build() == CLBVH_INTERNAL);
    CHECK(std::string(clbvh_last_error()) == "thrown by the callback");
    REQUIRE(clbvh_set_progress(builder, nullptr, nullptr) == CLBVH_OK);
    CHECK(build() == CLBVH_OK);
    clbvh_destroy_builder(builder);
}
