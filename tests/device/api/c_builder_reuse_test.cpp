// A builder of the C interface on a device: which calls cost it its programs and memory.

#include <catch2/catch.hpp>
#include <cstddef>
#include <string>

#include "clbvh/clbvh.h"
#include "clbvh/io/scene.hpp"
#include "support/opencl_calls.hpp"

namespace {

int count_call(void* user, const char*, double) {
    ++*static_cast<int*>(user);
    return 1;
}

struct CBuilder {
    CBuilder() { REQUIRE(clbvh_create_builder("plocpp", nullptr, &handle) == CLBVH_OK); }
    CBuilder(const CBuilder&) = delete;
    CBuilder& operator=(const CBuilder&) = delete;
    ~CBuilder() { clbvh_destroy_builder(handle); }

    /// Buffers that a build makes.
    [[nodiscard]] std::size_t buffers_of_build() const {
        return clbvh::test::opencl_calls_of([&] {
                   REQUIRE(clbvh_build(handle, &mesh.vertices.data()->x, mesh.vertices.size(),
                                       mesh.triangles.data()->data(), mesh.triangles.size()) == CLBVH_OK);
               })
            .buffers;
    }

    [[nodiscard]] std::size_t buffers_with_radius(const char* value) const {
        REQUIRE(clbvh_set_option(handle, "ploc.search_radius", value) == CLBVH_OK);
        return buffers_of_build();
    }

    clbvh::Mesh mesh = clbvh::generate_scene("soup", 2000);
    clbvh_builder* handle = nullptr;
};

}  // namespace

TEST_CASE("setting the value that is there keeps the programs and the memory of the last build") {
    const CBuilder c;
    const std::size_t first = c.buffers_of_build();
    const std::size_t again = c.buffers_of_build();
    REQUIRE(first > again);
    CHECK(c.buffers_with_radius("16") == again);
    CHECK(c.buffers_with_radius("8") > again);
    CHECK(c.buffers_with_radius("8") == again);
    CHECK(clbvh_set_option(c.handle, "ploc.search_radius", "33") == CLBVH_INVALID_INPUT);
    CHECK(c.buffers_of_build() == again);
    CHECK(std::string(clbvh_get_option(c.handle, "ploc.search_radius")) == "8");
}

TEST_CASE("another callback keeps the programs and the memory of the last build, and is the one that is called") {
    const CBuilder c;
    int calls = 0;
    int calls_of_other = 0;
    REQUIRE(clbvh_set_progress(c.handle, count_call, &calls) == CLBVH_OK);
    static_cast<void>(c.buffers_of_build());
    const std::size_t again = c.buffers_of_build();
    REQUIRE(calls > 0);
    const int before = calls;
    REQUIRE(clbvh_set_progress(c.handle, count_call, &calls_of_other) == CLBVH_OK);
    CHECK(c.buffers_of_build() == again);
    CHECK(calls == before);
    CHECK(calls_of_other > 0);
    REQUIRE(clbvh_set_progress(c.handle, nullptr, nullptr) == CLBVH_OK);
    const int before_none = calls_of_other;
    static_cast<void>(c.buffers_of_build());
    CHECK(calls_of_other == before_none);
}
