#include <catch2/catch.hpp>

#include "trace/fast_math/axis_rays.hpp"

using namespace clbvh::test;

TEST_CASE("header code visits the right leaves whatever the caller's flags for floats") {
    struct Compiled {
        const char* flags;
        AxisRaysFound (*find)();
    };
    for (const auto& [flags, find] : {Compiled{"none", axis_rays_without_flags},
                                      {"-ffast-math", axis_rays_fast_math},
                                      {"-Ofast", axis_rays_ofast},
                                      {"-ffinite-math-only", axis_rays_finite_math_only},
                                      {"-funsafe-math-optimizations", axis_rays_unsafe_math}}) {
        INFO(flags);
        const AxisRaysFound found = find();
        CHECK(found.rays == 1944);
        CHECK(found.wrong == 0);
        CHECK(found.invalid_traced == 0);
        CHECK(found.bounds == clbvh::Aabb{{0.0f, 0.0f, 0.0f}, {7.0f, 7.0f, 7.0f}});
    }
}
