// Structures of callers that were compiled with another version of clbvh.h.

#include "c/known_fields.hpp"

#include <catch2/catch.hpp>
#include <cstddef>
#include <vector>

#include "clbvh/clbvh.h"
#include "support/expect_error.hpp"

using clbvh::c::known_fields;
using clbvh::c::write_known_fields;

namespace {

/// Its first version ended before `later`.
struct Example {
    std::uint32_t size;
    std::uint32_t value;
    std::uint64_t later;
};
constexpr std::size_t kFirst = offsetof(Example, later);

/// What a caller has whose structure is so large: where it ends, so does the memory.
struct Caller {
    explicit Caller(std::uint32_t bytes) : words(bytes / 4, 0x77777777u) { words[0] = bytes; }
    [[nodiscard]] Example& structure() { return *reinterpret_cast<Example*>(words.data()); }
    std::vector<std::uint32_t> words;
};

clbvh_error build_one(clbvh_builder* builder, std::uint32_t size, float* boxes) {
    clbvh_box_view view{size, 0, boxes, 1};
    return clbvh_build_boxes(builder, &view);
}

}  // namespace

TEST_CASE("fields that the caller does not know are 0, and those that the library does not know are left alone") {
    Caller first(kFirst);
    first.words[1] = 5;
    const Example of_first = known_fields(first.structure(), kFirst, "example");
    CHECK(of_first.size == kFirst);
    CHECK(of_first.value == 5);
    CHECK(of_first.later == 0);
    Caller between(kFirst + 4);
    CHECK(known_fields(between.structure(), kFirst, "example").later != 0);
    Caller to_come(sizeof(Example) + 8);
    CHECK(known_fields(to_come.structure(), kFirst, "example").later == 0x7777777777777777u);
    Caller too_small(kFirst - 4);
    clbvh::test::expect_error(clbvh::ErrorCode::invalid_input, {"example.size is 4", "sizeof(example)"},
                              [&] { static_cast<void>(known_fields(too_small.structure(), kFirst, "example")); });
}

TEST_CASE("no field is written that the caller does not have") {
    const Example written{99, 6, 7};
    Caller first(kFirst);
    write_known_fields(written, first.structure());
    CHECK(first.words == std::vector<std::uint32_t>{kFirst, 6});
    Caller to_come(sizeof(Example) + 4);
    write_known_fields(written, to_come.structure());
    CHECK(to_come.words == std::vector<std::uint32_t>{sizeof(Example) + 4, 6, 7, 0, 0x77777777u});
}

TEST_CASE("views of the C interface may be larger than this version's, and not smaller than the first version's") {
    static_assert(sizeof(void*) != 8 || (sizeof(clbvh_box_view) == 24 && sizeof(clbvh_mesh_view) == 48));
    float box[6] = {0, 0, 0, 1, 1, 1};
    clbvh_builder* builder = nullptr;
    REQUIRE(clbvh_create_builder("median", nullptr, &builder) == CLBVH_OK);
    CHECK(build_one(builder, sizeof(clbvh_box_view), box) == CLBVH_OK);
    CHECK(build_one(builder, sizeof(clbvh_box_view) - 1, box) == CLBVH_INVALID_INPUT);
    struct {
        clbvh_box_view known;
        std::uint64_t later;
    } boxes_to_come{{sizeof(boxes_to_come), 0, box, 1}, 42};
    CHECK(clbvh_build_boxes(builder, &boxes_to_come.known) == CLBVH_OK);
    const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    struct {
        clbvh_mesh_view known;
        std::uint64_t later;
    } mesh_to_come{{sizeof(mesh_to_come), 0, vertices, 3, nullptr, 1, 0, 0}, 42};
    CHECK(clbvh_build_mesh(builder, &mesh_to_come.known) == CLBVH_OK);
    mesh_to_come.known.size = sizeof(clbvh_mesh_view) - 4;
    CHECK(clbvh_build_mesh(builder, &mesh_to_come.known) == CLBVH_INVALID_INPUT);
    clbvh_destroy_builder(builder);
}
