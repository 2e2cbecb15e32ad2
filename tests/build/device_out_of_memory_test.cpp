// Memory that runs out around a device: every buffer of a build with optimisers fails once, and the first allocations
// of an optimiser, and each time an Error(out_of_memory) comes out, and the builder or the optimiser still works.
#include <catch2/catch.hpp>
#include <utility>

#include "clbvh/core/error.hpp"
#include "clbvh/device/device_optimizer.hpp"
#include "clbvh/io/scene.hpp"
#include "support/allocations.hpp"
#include "support/builders.hpp"
#include "support/opencl_calls.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("device memory that runs out anywhere in a build with optimizers is an Error, and the builder still works") {
    const Mesh mesh = generate_scene("hair", 3000);
    BuildOptions options;
    options.optimizers = "treelet,reinsert";
    options.optimize_on = OptimizeOn::device;
    const Bvh expected = make_builder("hploc", options).build(mesh);
    long failures = 0;
    for (bool is_built = false; !is_built && failures < 1000;) {
        Builder fresh = make_builder("hploc", options);
        fresh.upload(mesh);
        allow_buffers(failures);
        try {
            fresh.run();
            allow_buffers();
            is_built = true;
        } catch (const Error& error) {
            allow_buffers();
            REQUIRE(error.code() == ErrorCode::out_of_memory);
            ++failures;
        } catch (...) {
            allow_buffers();
            FAIL("something else than an Error came out after " << failures << " buffers");
        }
        REQUIRE(same_bytes(fresh.build(mesh), expected));
    }
    CHECK(failures > 20);
}

TEST_CASE("an allocation that fails before a tree goes to the device is an Error, and the optimizer still works") {
    const Bvh tree = built_tree("lbvh", generate_scene("hair", 3000));
    DeviceOptimizer optimizer("treelet", shared_context());
    const Bvh expected = optimizer.optimize(tree);
    for (long allowed = 0; allowed < 3; ++allowed) {
        Bvh given = tree;
        allow_allocations(allowed);
        try {
            static_cast<void>(optimizer.optimize(std::move(given)));
            allow_allocations(-1);
            FAIL("nothing was told");
        } catch (const Error& error) {
            allow_allocations(-1);
            REQUIRE(error.code() == ErrorCode::out_of_memory);
        }
        REQUIRE(same_bytes(optimizer.optimize(tree), expected));
    }
}
