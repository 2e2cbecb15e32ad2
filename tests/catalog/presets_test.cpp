// A preset is its builder with its options, wherever an id may stand, and each costs rays less than the one before.
#include "clbvh/catalog.hpp"

#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
#include "clbvh/device/device_builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("presets: each is a builder with options, the same bytes as with both by hand") {
    const Mesh mesh = generate_scene("hair", 5000);
    double last = 1e9;
    for (const PresetInfo& preset : presets()) {
        INFO(preset.id);
        CHECK_NOTHROW(check_optimizers(preset.optimizers));
        CHECK(find_preset(preset.id) == &preset);
        Builder builder = make_builder(preset.id);
        CHECK(builder.id() == preset.id);
        CHECK(builder.info().id == preset.builder);
        const Bvh tree = builder.build(mesh);
        CHECK(validate(tree, mesh).error == "");

        BuildOptions options;
        options.optimizers = preset.optimizers;
        options.optimize_passes = preset.optimize_passes;
        options.max_leaf_size = preset.max_leaf_size;
        Builder by_hand = make_builder(preset.builder, options);
        CHECK(by_hand.id() == preset.builder);
        CHECK(same_bytes(tree, by_hand.build(mesh)));
        CHECK(sah_cost(tree) < last);
        last = sah_cost(tree);
    }
}

TEST_CASE("presets: what a caller sets wins") {
    BuildOptions options;
    options.max_leaf_size = 2;
    options.optimizers = "rotate";
    const BuildOptions merged = make_builder("balanced", options).options();
    CHECK(merged.max_leaf_size == 2);
    CHECK(merged.optimizers == "rotate");
    CHECK(merged.optimize_passes == 0);
    options.optimizers.clear();
    CHECK(make_builder("balanced", options).options().optimize_passes == find_preset("balanced")->optimize_passes);
    options.optimize_passes = 5;
    CHECK(make_builder("balanced", options).options().optimize_passes == 5);
    CHECK(with_preset("plocpp", options).optimize_passes == 5);
    CHECK(with_preset("plocpp", {}).optimize_passes == 0);
}

TEST_CASE("presets: unknown ids are answered with builders and presets") {
    CHECK(find_preset("quick") == nullptr);
    expect_error(ErrorCode::invalid_input, {"unknown builder 'quick'", "plocpp", "balanced"},
                 [] { static_cast<void>(make_builder("quick")); });
}

TEST_CASE("presets: from device memory where nothing of them is the host's work") {
    CHECK(DeviceBuilder("fast", shared_context()).info().id == "plocpp");
    expect_error(ErrorCode::unsupported, {"the preset balanced merges leaves", "hploc with optimizers reinsert"},
                 [] { static_cast<void>(DeviceBuilder("balanced", shared_context())); });
    expect_error(ErrorCode::unsupported, {"host"}, [] { static_cast<void>(DeviceBuilder("high", shared_context())); });
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
