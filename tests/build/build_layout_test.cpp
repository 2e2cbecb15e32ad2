// Builders that go straight to what rays are traced through.
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

bool same_layouts(const Wide8& a, const Wide8& b) {
    const auto same = [](const auto& x, const auto& y) {
        return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0);
    };
    return same(a.nodes, b.nodes) && same(a.blocks, b.blocks) && a.depth == b.depth &&
           a.primitive_count == b.primitive_count;
}

std::vector<std::string> all_ids() {
    std::vector<std::string> ids;
    for (const BuilderInfo& info : builders())
        ids.emplace_back(info.id);
    for (const PresetInfo& preset : presets())
        ids.emplace_back(preset.id);
    return ids;
}

}  // namespace

TEST_CASE("the layout that a builder makes is that of its tree") {
    Mesh mesh = generate_scene("city", 3000);
    mesh.vertices[mesh.triangles[7][1]].y = std::numeric_limits<float>::quiet_NaN();
    const Mesh small = generate_scene("hair", 50);
    for (const std::string& id : all_ids()) {
        if (!can_run(id)) continue;
        INFO(id);
        Builder builder = make_builder(id);
        Wide8 layout;
        BuildStats stats;
        LayoutOptions options;
        options.opening = builder.options().opening;
        builder.build_layout(mesh, layout, &stats);
        CHECK(same_layouts(layout, make_layout<Wide8>(builder.build(mesh), mesh, options)));
        REQUIRE_FALSE(stats.stages.empty());
        CHECK(stats.stages.back().name == "wide8");
        builder.build_layout(small, layout);
        CHECK(same_layouts(layout, make_layout<Wide8>(builder.build(small), small, options)));
        builder.build_layout(Mesh{}, layout);
        CHECK(layout.empty());
    }
}

TEST_CASE("a builder's option says how wide nodes are opened") {
    const Mesh mesh = generate_scene("city", 3000);
    BuildOptions options;
    options.opening = NodeOpening::least_cost;
    Wide8 layout;
    make_builder("median", options).build_layout(mesh, layout);
    const Bvh tree = make_builder("median").build(mesh);
    LayoutOptions least_cost;
    least_cost.opening = NodeOpening::least_cost;
    CHECK(same_layouts(layout, make_layout<Wide8>(tree, mesh, least_cost)));
    CHECK_FALSE(same_layouts(layout, make_layout<Wide8>(tree, mesh)));
}

TEST_CASE("what stages before and behind a builder change is laid out") {
    const Mesh mesh = generate_scene("hair", 2000);
    BuildOptions options;
    options.presplit_level = 14;
    options.max_leaf_size = 4;
    options.optimizers = "reinsert";
    Builder builder("binned-sah", options);
    Wide8 layout;
    builder.build_layout(mesh, layout);
    CHECK(same_layouts(layout, make_layout<Wide8>(builder.build(mesh), mesh)));
}

TEST_CASE("a tracer that a builder makes finds what one over its tree finds") {
    const Mesh mesh = generate_scene("soup", 3000);
    const Tracer tracer = build_tracer(mesh, "binned-sah"), expected(build(mesh, "binned-sah"), mesh);
    std::size_t differences = 0;
    for (const Ray& ray : difficult_rays(mesh, 200))
        differences += same_bits(tracer.closest(ray), expected.closest(ray)) ? 0 : 1;
    CHECK(differences == 0);
}

TEST_CASE("a build that fails leaves an empty layout") {
    const Mesh mesh = generate_scene("soup", 100);
    Mesh bad = mesh;
    bad.triangles[3][1] = 4000000000u;
    Builder builder("binned-sah");
    Wide8 layout;
    builder.build_layout(mesh, layout);
    CHECK_FALSE(layout.empty());
    expect_error(ErrorCode::invalid_input, {"triangle 3"}, [&] { builder.build_layout(bad, layout); });
    CHECK(layout.empty());
    CHECK(layout.blocks.empty());
    builder.build_layout(mesh, layout);
    CHECK_FALSE(layout.empty());
}
