// Presets whose builder runs on a device.
#include <catch2/catch.hpp>

#include "clbvh/catalog.hpp"
#include "clbvh/device/device_builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("presets: what a caller sets wins") {
    BuildOptions options;
    options.max_leaf_size = 2;
    options.optimizers = "rotate";
    const BuildOptions merged = make_builder("balanced", options).options();
    CHECK(merged.max_leaf_size == 2);
    CHECK(merged.hploc.leaf_size == 2);  // of the preset's 4
    CHECK(merged.optimizers == "rotate");
    CHECK(merged.optimize_passes == 0);
    options.optimizers.clear();
    CHECK(make_builder("balanced", options).options().optimize_passes == find_preset("balanced")->optimize_passes);
    options.optimize_passes = 5;
    CHECK(make_builder("balanced", options).options().optimize_passes == 5);
    CHECK(with_preset("plocpp", options).optimize_passes == 5);
    CHECK(with_preset("plocpp", {}).optimize_passes == 0);
}

TEST_CASE("presets: from device memory where nothing of them is the host's work") {
    for (const char* id : {"fast", "balanced"})
        CHECK(DeviceBuilder(id, shared_context()).info().id == "hploc");
    expect_error(ErrorCode::unsupported, {"the preset high merges leaves", "hploc with optimizers reinsert"},
                 [] { static_cast<void>(DeviceBuilder("high", shared_context())); });
    expect_error(ErrorCode::unsupported, {"host"},
                 [] { static_cast<void>(DeviceBuilder("highest", shared_context())); });
}

TEST_CASE("presets: passes end an optimizer behind a builder") {
    const Mesh mesh = generate_scene("city", 5000);
    BuildOptions options;
    options.optimizers = "reinsert";
    const double full = sah_cost(make_builder("lbvh", options).build(mesh));
    options.optimize_passes = 1;
    const double once = sah_cost(make_builder("lbvh", options).build(mesh));
    options.optimizers.clear();
    const double never = sah_cost(make_builder("lbvh", options).build(mesh));
    CHECK(full < once);
    CHECK(once < never);
}
