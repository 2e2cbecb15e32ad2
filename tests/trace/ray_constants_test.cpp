// The headers are installed without the kernels, and so state these numbers again.

#include "kernels/trace/ray_constants.h"

#include <catch2/catch.hpp>

#include "clbvh/core/ray.hpp"
#include "clbvh/trace/box_tests.hpp"

TEST_CASE("kernels and headers have the same numbers for rays that hit nothing and for the margin of boxes") {
    STATIC_REQUIRE(clbvh::kNoPrimitive == NO_PRIMITIVE);
    STATIC_REQUIRE(clbvh::kBoxSlack == BOX_SLACK);
}
