// A preset is its builder with its options, wherever an id may stand, and each costs rays less than the one before.
#include "clbvh/catalog.hpp"

#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
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
        if (!can_run(preset.id)) continue;
        INFO(preset.id);
        CHECK_NOTHROW(check_optimizers(preset.optimizers));
        CHECK(find_preset(preset.id) == &preset);
        Builder builder = make_builder(preset.id);
        CHECK(builder.id() == preset.id);
        CHECK(builder.info().id == preset.builder);
        const Bvh tree = builder.build(mesh);
        CHECK(validate(tree, mesh).error.empty());

        BuildOptions options;
        options.optimizers = preset.optimizers;
        options.optimize_passes = preset.optimize_passes;
        options.max_leaf_size = preset.max_leaf_size;
        if (preset.leaf_size > 0) options.hploc.leaf_size = preset.leaf_size;
        if (preset.code_bits > 0) options.device.code_bits = preset.code_bits;
        options.opening = preset.opening;
        if (preset.split_overlap > 0.0f) options.sbvh.overlap = preset.split_overlap;
        Builder by_hand = make_builder(preset.builder, options);
        CHECK(by_hand.id() == preset.builder);
        CHECK(same_bytes(tree, by_hand.build(mesh)));
        CHECK(sah_cost(tree) < last);
        last = sah_cost(tree);
    }
}

TEST_CASE("presets: unknown ids are answered with builders and presets") {
    CHECK(find_preset("quick") == nullptr);
    expect_error(ErrorCode::invalid_input, {"unknown builder 'quick'", "plocpp", "balanced"},
                 [] { static_cast<void>(make_builder("quick")); });
}
