// Builders on real meshes: the folder that CLBVH_SCENES names, where it is set.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/epo.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Nothing, and a word about it, where there is no such mesh here.
std::optional<Mesh> load_scene_mesh(const std::string& name) {
    const char* folder = std::getenv("CLBVH_SCENES");
    if (folder == nullptr || *folder == '\0') {
        WARN("SKIPPED: CLBVH_SCENES names no folder of meshes");
        return std::nullopt;
    }
    const std::filesystem::path path = std::filesystem::path(folder) / (name + ".ply");
    if (!std::filesystem::exists(path)) {
        WARN("SKIPPED: there is no " << path);
        return std::nullopt;
    }
    return load_scene(path.string());
}

Builder make_large_builder(std::string_view id, Shape shape) {
    BuildOptions options = options_of(shape);
    options.range_count = 64;
    return make_builder(id, options);
}

void expect_good_trees(const Mesh& mesh) {
    double exact_cost = 0.0;
    for (const std::string_view id : device_builders()) {
        INFO(id);
        Builder lane = make_large_builder(id, Shape::lane);
        Builder group = make_large_builder(id, Shape::group);
        const Bvh bvh = lane.build(mesh);
        CHECK(same_bytes(group.build(mesh), bvh));
        CHECK(validate(bvh, mesh).error == "");
        const double cost = sah_cost(bvh);
        if (id == "ploc") exact_cost = cost;
        if (id == "plocpp") CHECK(cost <= 1.02 * exact_cost);
        if (id == "plocpp-two-level") CHECK(cost <= 1.06 * exact_cost);
    }
}

void expect_good_trees_of(const std::string& name) {
    const std::optional<Mesh> mesh = load_scene_mesh(name);
    if (mesh) expect_good_trees(*mesh);
}

}  // namespace

TEST_CASE("builders on the mesh bunny") {
    expect_good_trees_of("bunny");
}
TEST_CASE("builders on the mesh kitchen_obvhs") {
    expect_good_trees_of("kitchen_obvhs");
}
TEST_CASE("builders on the mesh living_room") {
    expect_good_trees_of("living_room");
}

TEST_CASE("end-point overlap of real meshes, exact and from samples") {
    for (const char* name : {"kitchen_obvhs", "staircase"}) {
        const std::optional<Mesh> mesh = load_scene_mesh(name);
        if (!mesh) return;
        INFO(name);
        double splitting = 0.0;
        for (const char* id : {"sbvh", "binned-sah", "locally-ordered"}) {
            INFO(id);
            const Bvh bvh = make_builder(id).build(*mesh);
            const double exact = end_point_overlap(bvh, *mesh);
            const Estimate estimate = end_point_overlap_sampled(bvh, *mesh, 100000);
            CHECK(std::abs(estimate.value - exact) < 4.5 * estimate.standard_error);
            if (splitting == 0.0) splitting = exact;
            // Spatial splits are what keeps triangles out of each other's boxes.
            CHECK(splitting <= exact);
        }
    }
}

TEST_CASE("builders on larger generated scenes") {
    for (const std::string_view scene : {"terrain", "sphere", "city"}) {
        INFO(scene);
        expect_good_trees(generate_scene(scene, 100000));
    }
}
