// The C interface: the same tree as the C++ one, every documented failure as a code and a message, and a compile as C.

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "clbvh/clbvh.h"
#include "clbvh/clbvh.hpp"
#include "clbvh/io/scene.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/c_builder.hpp"
#include "support/views.hpp"

namespace {

using clbvh::Mesh;
using clbvh::test::build;
using clbvh::test::CBuilder;

}  // namespace

TEST_CASE("host builders work through the C interface without any device") {
    const Mesh mesh = clbvh::generate_scene("hair", 2000);
    for (const clbvh::BuilderInfo& info : clbvh::builders()) {
        if (info.kind != clbvh::BuilderKind::host) continue;
        INFO(info.id);
        CBuilder c;
        REQUIRE(clbvh_create_builder(std::string(info.id).c_str(), "no such device", &c.handle) == CLBVH_OK);
        CHECK(clbvh_has_split_references(c.handle) == 0);
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        const clbvh::Bvh expected = clbvh::build(mesh, info.id);
        std::uint64_t node_count = 0;
        std::uint64_t id_count = 0;
        const clbvh_node* nodes = clbvh_nodes(c.handle, &node_count);
        const std::uint32_t* ids = clbvh_primitive_ids(c.handle, &id_count);
        REQUIRE(node_count == expected.nodes.size());
        CHECK(std::memcmp(nodes, expected.nodes.data(), node_count * sizeof(clbvh_node)) == 0);
        CHECK(std::vector(ids, ids + id_count) == expected.primitive_ids);
        CHECK(clbvh_has_split_references(c.handle) == (expected.split_references ? 1 : 0));
        CHECK(((id_count > mesh.triangles.size()) == expected.split_references));
    }
}

TEST_CASE("the C interface reports failures as codes and messages") {
    CBuilder c;
    CHECK(clbvh_create_builder("nonsense", nullptr, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK(std::string(clbvh_last_error()).find("plocpp") != std::string::npos);
    CHECK(c.handle == nullptr);
    CHECK(clbvh_create_builder(nullptr, nullptr, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_create_builder("plocpp", nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_build(nullptr, nullptr, 0, nullptr, 0) == CLBVH_INVALID_INPUT);
    std::uint64_t count = 1;
    CHECK(clbvh_nodes(nullptr, &count) == nullptr);
    CHECK(clbvh_has_split_references(nullptr) == 0);
    CHECK(count == 0);
}

TEST_CASE("presets stand for builders in the C interface") {
    const Mesh mesh = clbvh::generate_scene("city", 3000);
    for (const clbvh::PresetInfo& preset : clbvh::presets()) {
        if (!clbvh::test::can_run(preset.id)) continue;
        INFO(preset.id);
        CBuilder c;
        REQUIRE(clbvh_create_builder(std::string(preset.id).c_str(), nullptr, &c.handle) == CLBVH_OK);
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        const clbvh::Bvh expected = clbvh::build(mesh, preset.id);
        std::uint64_t count = 0;
        const clbvh_node* nodes = clbvh_nodes(c.handle, &count);
        REQUIRE(count == expected.nodes.size());
        CHECK(std::memcmp(nodes, expected.nodes.data(), count * sizeof(clbvh_node)) == 0);
    }
}

TEST_CASE("the C interface has the table of options") {
    REQUIRE(clbvh_option_count() == clbvh::options().size());
    for (std::uint32_t i = 0; i < clbvh_option_count(); ++i) {
        const clbvh::OptionInfo& expected = clbvh::options()[i];
        const clbvh_option* const option = clbvh_option_info(i);
        REQUIRE(option != nullptr);
        INFO(option->name);
        CHECK(option->name == expected.name);
        CHECK(option->type == static_cast<clbvh_option_type>(expected.type));
        CHECK(option->values == expected.values);
        CHECK(option->default_value == expected.default_value);
        CHECK(option->help == expected.help);
        CHECK(option->readers == expected.readers);
        CHECK(clbvh_option_info(i) == option);
    }
    CHECK(clbvh_option_info(clbvh_option_count()) == nullptr);
    static_assert(CLBVH_OPTION_TEXT == static_cast<int>(clbvh::OptionType::text));
}

TEST_CASE("options are set by name through the C interface, and refused with their range") {
    CBuilder c;
    REQUIRE(clbvh_create_builder("median", nullptr, &c.handle) == CLBVH_OK);
    for (const clbvh::OptionInfo& info : clbvh::options()) {
        const std::string name(info.name);
        INFO(name);
        CHECK(clbvh_get_option(c.handle, name.c_str()) == info.default_value);
        CHECK(clbvh_set_option(c.handle, name.c_str(), info.default_value.c_str()) == CLBVH_OK);
        CHECK(clbvh_set_option(c.handle, name.c_str(), "no such value") == CLBVH_INVALID_INPUT);
        if (info.type != clbvh::OptionType::text)
            CHECK_THAT(clbvh_last_error(), Catch::Contains(name) && Catch::Contains(info.values));
        CHECK(clbvh_get_option(c.handle, name.c_str()) == info.default_value);
    }
    CHECK(clbvh_set_option(c.handle, "optimizers", "reinzert") == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("reinzert"));
    CHECK(clbvh_set_option(c.handle, "binned_sah.bin_count", "65") == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("bin_count is 65; it must be 2 to 64"));
    CHECK(clbvh_set_option(c.handle, "bin_count", "8") == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("did you mean binned_sah.bin_count or sbvh.bin_count"));
    CHECK(clbvh_get_option(c.handle, "bin_count") == nullptr);
    for (const char* const text : {static_cast<const char*>(nullptr), "thread_count"}) {
        CHECK(clbvh_set_option(c.handle, text, nullptr) == CLBVH_INVALID_INPUT);
        CHECK(clbvh_set_option(c.handle, nullptr, text) == CLBVH_INVALID_INPUT);
        CHECK(clbvh_set_option(nullptr, text, "1") == CLBVH_INVALID_INPUT);
        CHECK(clbvh_get_option(nullptr, text) == nullptr);
    }
    CHECK(clbvh_get_option(c.handle, nullptr) == nullptr);
}

TEST_CASE("options that contradict each other make a build through the C interface fail, until they do not") {
    const Mesh mesh = clbvh::generate_scene("hair", 500);
    CBuilder c;
    REQUIRE(clbvh_create_builder("median", nullptr, &c.handle) == CLBVH_OK);
    REQUIRE(clbvh_set_option(c.handle, "presplit_level", "8") == CLBVH_OK);
    REQUIRE(clbvh_set_option(c.handle, "split_quota", "0.3") == CLBVH_OK);
    CHECK(build(c.handle, mesh) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("split_quota"));
    REQUIRE(clbvh_set_option(c.handle, "split_quota", "0") == CLBVH_OK);
    CHECK(build(c.handle, mesh) == CLBVH_OK);
    CHECK(clbvh_has_split_references(c.handle) == 1);
}

namespace {

clbvh::Bvh tree_of(const clbvh_builder* builder, std::uint64_t primitives) {
    clbvh::Bvh tree;
    std::uint64_t count = 0;
    const clbvh_node* nodes = clbvh_nodes(builder, &count);
    tree.nodes.resize(count);
    if (count > 0) std::memcpy(static_cast<void*>(tree.nodes.data()), nodes, count * sizeof(clbvh_node));
    const std::uint32_t* ids = clbvh_primitive_ids(builder, &count);
    tree.primitive_ids.assign(ids, ids + count);
    tree.primitive_count = primitives;
    tree.split_references = clbvh_has_split_references(builder) != 0;
    return tree;
}

clbvh_error refit(clbvh_builder* builder, const Mesh& mesh, double* before, double* after) {
    return clbvh_refit(builder, &mesh.vertices.data()->x, mesh.vertices.size(), mesh.triangles.data()->data(),
                       mesh.triangles.size(), before, after);
}

int count_and_stop(void* user, const char*, double) {
    return --*static_cast<int*>(user) > 0 ? 1 : 0;
}

}  // namespace

TEST_CASE("builds through the C interface run optimizers and split by a quota") {
    const Mesh mesh = clbvh::generate_scene("hair", 3000);
    for (const char* const ids : {"reinsert", "treelet-split"}) {
        CBuilder c;
        REQUIRE(clbvh_create_builder("binned-sah", nullptr, &c.handle) == CLBVH_OK);
        REQUIRE(clbvh_set_option(c.handle, "optimizers", ids) == CLBVH_OK);
        REQUIRE(clbvh_set_option(c.handle, "split_quota", "0.2") == CLBVH_OK);
        REQUIRE(clbvh_set_option(c.handle, "optimize_passes", "1") == CLBVH_OK);
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        clbvh::BuildOptions same;
        same.optimizers = ids;
        same.split_quota = 0.2f;
        same.optimize_passes = 1;
        const clbvh::Bvh expected = clbvh::build(mesh, "binned-sah", same);
        CHECK(tree_of(c.handle, 3000).nodes == expected.nodes);
        CHECK(clbvh_has_split_references(c.handle) == 1);
    }
}

TEST_CASE("a finished tree is improved through the C interface, within a budget") {
    const Mesh mesh = clbvh::generate_scene("city", 5000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("median", nullptr, &c.handle) == CLBVH_OK);
    CHECK(clbvh_optimize(c.handle, "reinsert", nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("clbvh_build"));
    REQUIRE(build(c.handle, mesh) == CLBVH_OK);
    const clbvh::Bvh plain = tree_of(c.handle, 5000);

    clbvh_optimize_stats stats{};
    stats.size = sizeof stats;
    clbvh_budget budget{};
    budget.size = sizeof budget;
    budget.passes = 2;
    REQUIRE(clbvh_optimize(c.handle, "rotate,reinsert", &budget, &stats) == CLBVH_OK);
    clbvh::OptimizeBudget same;
    same.passes = 2;
    const clbvh::Bvh expected = clbvh::optimize(plain, "rotate,reinsert", same);
    const clbvh::Bvh better = tree_of(c.handle, 5000);
    CHECK(better.nodes == expected.nodes);
    CHECK(stats.passes == 4);
    CHECK(stats.changes > 0);
    CHECK(stats.is_cancelled == 0);
    CHECK(stats.sah_before == clbvh::sah_cost(plain));
    CHECK(stats.sah_after == clbvh::sah_cost(better));
    CHECK(stats.sah_after < stats.sah_before);

    int calls = 1;
    budget.passes = 0;
    budget.progress = count_and_stop;
    budget.progress_user = &calls;
    CHECK(clbvh_optimize(c.handle, "rotate", &budget, &stats) == CLBVH_OK);
    CHECK(stats.is_cancelled == 1);
    CHECK(clbvh::validate(tree_of(c.handle, 5000), mesh).error == "");

    // Callers that were compiled with a later version know more fields; those are theirs alone.
    struct {
        clbvh_optimize_stats known;
        std::uint64_t later;
    } stats_to_come{{}, 42};
    struct {
        clbvh_budget known;
        std::uint64_t later;
    } budget_to_come{{}, 43};
    stats_to_come.known.size = sizeof stats_to_come;
    budget_to_come.known.size = sizeof budget_to_come;
    CHECK(clbvh_optimize(c.handle, "rotate", &budget_to_come.known, &stats_to_come.known) == CLBVH_OK);
    CHECK(stats_to_come.known.size == sizeof stats_to_come);
    CHECK(stats_to_come.known.sah_after > 1.0);
    CHECK(stats_to_come.later == 42);

    const clbvh::Bvh last = tree_of(c.handle, 5000);
    for (const double milliseconds : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
        budget.milliseconds = milliseconds;
        CHECK(clbvh_optimize(c.handle, "rotate", &budget, nullptr) == CLBVH_INVALID_INPUT);
        CHECK_THAT(clbvh_last_error(), Catch::Contains("milliseconds"));
    }
    budget.milliseconds = 0.0;
    budget.size = 0;
    CHECK(clbvh_optimize(c.handle, "rotate", &budget, nullptr) == CLBVH_INVALID_INPUT);
    stats.size = 0;
    CHECK(clbvh_optimize(c.handle, "rotate", nullptr, &stats) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_optimize(c.handle, "rotated", nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_optimize(c.handle, nullptr, nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_optimize(nullptr, "rotate", nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_optimize(c.handle, "treelet-split", nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("split_quota"));
    CHECK(tree_of(c.handle, 5000).nodes == last.nodes);
    CHECK(clbvh_optimize(c.handle, "reinsert", nullptr, nullptr) == CLBVH_OK);
}

TEST_CASE("a tree follows a mesh that moves through the C interface") {
    Mesh mesh = clbvh::generate_scene("clustered", 3000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("sweep-sah", nullptr, &c.handle) == CLBVH_OK);
    CHECK(refit(c.handle, mesh, nullptr, nullptr) == CLBVH_INVALID_INPUT);
    REQUIRE(build(c.handle, mesh) == CLBVH_OK);
    double last = clbvh::sah_cost(tree_of(c.handle, 3000));
    for (int frame = 0; frame < 3; ++frame) {
        for (clbvh::Vec3& vertex : mesh.vertices)
            vertex.x += 0.3f * vertex.y;
        double before = 0.0;
        double after = 0.0;
        REQUIRE(refit(c.handle, mesh, &before, &after) == CLBVH_OK);
        const clbvh::Bvh tree = tree_of(c.handle, 3000);
        CHECK(clbvh::validate(tree, mesh).error == "");
        CHECK(before == Approx(last));
        last = clbvh::sah_cost(tree);
        CHECK(after == Approx(last));
        if (frame == 1) CHECK(clbvh_optimize(c.handle, "rotate", nullptr, nullptr) == CLBVH_OK);
        last = clbvh::sah_cost(tree_of(c.handle, 3000));
    }
    const clbvh::Bvh tree = tree_of(c.handle, 3000);
    CHECK(refit(c.handle, clbvh::generate_scene("clustered", 2999), nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("2999 triangles"));
    CHECK(clbvh_refit(c.handle, nullptr, 3, nullptr, 0, nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK(tree_of(c.handle, 3000).nodes == tree.nodes);
    CHECK(refit(c.handle, mesh, nullptr, nullptr) == CLBVH_OK);
}

TEST_CASE("the C interface builds, refits and validates over views of triangles and boxes", "[views]") {
    const Mesh mesh = clbvh::generate_scene("hair", 1000);
    const std::vector<clbvh::Aabb> boxes = clbvh::test::random_boxes(1000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("binned-sah", nullptr, &c.handle) == CLBVH_OK);
    const auto tree_is = [&](const clbvh::Bvh& expected) {
        std::uint64_t count = 0;
        const clbvh_node* const nodes = clbvh_nodes(c.handle, &count);
        return count == expected.nodes.size() &&
               std::memcmp(nodes, expected.nodes.data(), count * sizeof(clbvh_node)) == 0;
    };
    const clbvh::Bvh over_mesh = clbvh::build(mesh, "binned-sah");
    for (const clbvh::test::ViewedMesh& layout : clbvh::test::layouts_of(mesh)) {
        INFO(layout.name);
        clbvh_mesh_view view{};
        view.size = sizeof(view);
        view.vertices = layout.view.vertices;
        view.vertex_count = layout.view.vertex_count;
        view.vertex_stride = layout.view.vertex_stride;
        view.indices = layout.view.indices;
        view.triangle_count = layout.view.triangle_count;
        view.index_type = layout.view.index_type == clbvh::IndexType::uint16 ? CLBVH_INDEX_UINT16 : CLBVH_INDEX_UINT32;
        view.index_stride = layout.view.index_stride;
        REQUIRE(clbvh_build_mesh(c.handle, &view) == CLBVH_OK);
        CHECK(tree_is(over_mesh));
        CHECK(clbvh_validate_mesh(c.handle, &view) == CLBVH_OK);
        CHECK(clbvh_refit_mesh(c.handle, &view, nullptr, nullptr) == CLBVH_OK);
        CHECK(tree_is(over_mesh));
        view.triangle_count -= 1;
        CHECK(clbvh_validate_mesh(c.handle, &view) == CLBVH_INVALID_INPUT);
        CHECK(std::string(clbvh_last_error()).find("the mesh has") != std::string::npos);
        view.index_type = 2;
        CHECK(clbvh_build_mesh(c.handle, &view) == CLBVH_INVALID_INPUT);
        view.size = 0;
        CHECK(clbvh_build_mesh(c.handle, &view) == CLBVH_INVALID_INPUT);
        CHECK(clbvh_build_mesh(c.handle, nullptr) == CLBVH_INVALID_INPUT);
    }
    const clbvh::Bvh over_boxes = clbvh::build(boxes, "binned-sah");
    for (const clbvh::test::ViewedBoxes& layout : clbvh::test::layouts_of(boxes)) {
        INFO(layout.name);
        clbvh_box_view view{sizeof(view), layout.view.stride, layout.view.boxes, layout.view.count};
        REQUIRE(clbvh_build_boxes(c.handle, &view) == CLBVH_OK);
        CHECK(tree_is(over_boxes));
        CHECK(clbvh_validate_boxes(c.handle, &view) == CLBVH_OK);
        double before = 0.0, after = 0.0;
        CHECK(clbvh_refit_boxes(c.handle, &view, &before, &after) == CLBVH_OK);
        CHECK(before == after);
        CHECK(tree_is(over_boxes));
        view.count -= 1;
        CHECK(clbvh_refit_boxes(c.handle, &view, nullptr, nullptr) == CLBVH_INVALID_INPUT);
        view.stride = 20;
        CHECK(clbvh_build_boxes(c.handle, &view) == CLBVH_INVALID_INPUT);
    }
}
