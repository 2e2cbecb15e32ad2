// The C interface: the same tree as the C++ one, every documented failure as a code and a message, and a compile as C.

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "clbvh/clbvh.h"
#include "clbvh/clbvh.hpp"
#include "clbvh/io/scene.hpp"

extern "C" int clbvh_c_consumer(void);

namespace {

using clbvh::Mesh;

struct CBuilder {
    clbvh_builder* handle = nullptr;
    CBuilder() = default;
    CBuilder(const CBuilder&) = delete;
    CBuilder& operator=(const CBuilder&) = delete;
    ~CBuilder() { clbvh_destroy_builder(handle); }
};

clbvh_error build(clbvh_builder* builder, const Mesh& mesh) {
    return clbvh_build(builder, &mesh.vertices.data()->x, mesh.vertices.size(), mesh.triangles.data()->data(),
                       mesh.triangles.size());
}

int stop_at_once(void* user, const char* stage, double fraction) {
    *static_cast<std::string*>(user) = stage;
    return fraction < 0.0 ? 1 : 0;
}

}  // namespace

TEST_CASE("the C interface gives the C++ interface's tree") {
    const Mesh mesh = clbvh::generate_scene("clustered", 3000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("plocpp", nullptr, nullptr, &c.handle) == CLBVH_OK);
    REQUIRE(build(c.handle, mesh) == CLBVH_OK);
    const clbvh::Bvh expected = clbvh::build(mesh, "plocpp");
    std::uint64_t node_count = 0;
    std::uint64_t id_count = 0;
    const clbvh_node* nodes = clbvh_nodes(c.handle, &node_count);
    const std::uint32_t* ids = clbvh_primitive_ids(c.handle, &id_count);
    REQUIRE(node_count == expected.nodes.size());
    REQUIRE(id_count == expected.primitive_ids.size());
    CHECK(std::memcmp(nodes, expected.nodes.data(), node_count * sizeof(clbvh_node)) == 0);
    CHECK(std::memcmp(ids, expected.primitive_ids.data(), id_count * sizeof(std::uint32_t)) == 0);
}

TEST_CASE("host builders work through the C interface without any device") {
    const Mesh mesh = clbvh::generate_scene("hair", 2000);
    for (const clbvh::BuilderInfo& info : clbvh::builders()) {
        if (info.kind != clbvh::BuilderKind::host) continue;
        INFO(info.id);
        CBuilder c;
        REQUIRE(clbvh_create_builder(std::string(info.id).c_str(), "no such device", nullptr, &c.handle) == CLBVH_OK);
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

TEST_CASE("the C interface works from a C program") {
    CHECK(clbvh_c_consumer() == 0);
}

TEST_CASE("the C interface reports failures as codes and messages") {
    CBuilder c;
    CHECK(clbvh_create_builder("nonsense", nullptr, nullptr, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK(std::string(clbvh_last_error()).find("plocpp") != std::string::npos);
    CHECK(c.handle == nullptr);
    CHECK(clbvh_create_builder(nullptr, nullptr, nullptr, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_create_builder("plocpp", nullptr, nullptr, nullptr) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_create_builder("plocpp", "no such device", nullptr, &c.handle) == CLBVH_NO_DEVICE);
    clbvh_options options;
    clbvh_default_options(&options, sizeof(options));
    options.search_radius = 33;
    CHECK(clbvh_create_builder("plocpp", nullptr, &options, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK(std::string(clbvh_last_error()).find("search_radius") != std::string::npos);
    options.size = 0;
    CHECK(clbvh_create_builder("plocpp", nullptr, &options, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK(clbvh_build(nullptr, nullptr, 0, nullptr, 0) == CLBVH_INVALID_INPUT);
    std::uint64_t count = 1;
    CHECK(clbvh_nodes(nullptr, &count) == nullptr);
    CHECK(clbvh_has_split_references(nullptr) == 0);
    CHECK(count == 0);
}

TEST_CASE("a failed build through the C interface leaves no tree and a builder that works") {
    CBuilder c;
    REQUIRE(clbvh_create_builder("lbvh", "", nullptr, &c.handle) == CLBVH_OK);
    Mesh mesh = clbvh::generate_scene("soup", 100);
    REQUIRE(build(c.handle, mesh) == CLBVH_OK);
    const std::uint32_t good = mesh.triangles[7][1];
    mesh.triangles[7][1] = 1000000;
    CHECK(build(c.handle, mesh) == CLBVH_INVALID_INPUT);
    CHECK(std::string(clbvh_last_error()).find("triangle 7") != std::string::npos);
    CHECK(clbvh_nodes(c.handle, nullptr) == nullptr);
    CHECK(clbvh_build(c.handle, nullptr, 3, nullptr, 0) == CLBVH_INVALID_INPUT);
    mesh.triangles[7][1] = good;
    CHECK(build(c.handle, mesh) == CLBVH_OK);
}

TEST_CASE("options of another version's size are told apart") {
    clbvh_options options;
    clbvh_default_options(&options, sizeof(options));
    options.size = offsetof(clbvh_options, inner_cost) - 1;
    CBuilder c;
    CHECK(clbvh_create_builder("plocpp", nullptr, &options, &c.handle) == CLBVH_INVALID_INPUT);
    struct {
        clbvh_options known;
        unsigned char newer[16];
    } future = {};
    std::memset(&future, 0x5a, sizeof(future));
    clbvh_default_options(&future.known, sizeof(future));
    CHECK(future.newer[0] == 0x5a);  // what this library does not know it leaves alone
    CHECK(clbvh_create_builder("plocpp", nullptr, &future.known, &c.handle) == CLBVH_OK);
}

TEST_CASE("progress through the C interface names the stage and cancels") {
    std::string stage;
    clbvh_options options;
    clbvh_default_options(&options, sizeof(options));
    options.progress = stop_at_once;
    options.progress_user = &stage;
    CBuilder c;
    REQUIRE(clbvh_create_builder("plocpp", nullptr, &options, &c.handle) == CLBVH_OK);
    CHECK(build(c.handle, clbvh::generate_scene("soup", 100)) == CLBVH_CANCELLED);
    CHECK(stage == "bounds");
}

TEST_CASE("presets stand for builders in the C interface") {
    const Mesh mesh = clbvh::generate_scene("city", 3000);
    for (const clbvh::PresetInfo& preset : clbvh::presets()) {
        INFO(preset.id);
        CBuilder c;
        REQUIRE(clbvh_create_builder(std::string(preset.id).c_str(), nullptr, nullptr, &c.handle) == CLBVH_OK);
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        const clbvh::Bvh expected = clbvh::build(mesh, preset.id);
        std::uint64_t count = 0;
        const clbvh_node* nodes = clbvh_nodes(c.handle, &count);
        REQUIRE(count == expected.nodes.size());
        CHECK(std::memcmp(nodes, expected.nodes.data(), count * sizeof(clbvh_node)) == 0);
    }
}

TEST_CASE("the C interface knows both presets of hploc") {
    const Mesh mesh = clbvh::generate_scene("soup", 2000);
    clbvh_options options;
    clbvh_default_options(&options, sizeof(options));
    for (const std::uint32_t fast : {0u, 1u}) {
        options.hploc_quality = fast;
        CBuilder c;
        REQUIRE(clbvh_create_builder("hploc", nullptr, &options, &c.handle) == CLBVH_OK);
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        clbvh::BuildOptions same;
        same.hploc_quality = fast != 0 ? clbvh::HplocQuality::fast : clbvh::HplocQuality::balanced;
        const clbvh::Bvh expected = clbvh::build(mesh, "hploc", same);
        std::uint64_t count = 0;
        const clbvh_node* nodes = clbvh_nodes(c.handle, &count);
        REQUIRE(count == expected.nodes.size());
        CHECK(std::memcmp(nodes, expected.nodes.data(), count * sizeof(clbvh_node)) == 0);
    }
    clbvh_default_options(&options, sizeof(options));
    options.code_bits = 40;
    CBuilder unknown_bits;
    CHECK(clbvh_create_builder("hploc", nullptr, &options, &unknown_bits.handle) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("code_bits"));
    clbvh_default_options(&options, sizeof(options));
    options.hploc_quality = 2;
    CBuilder c;
    CHECK(clbvh_create_builder("hploc", nullptr, &options, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("hploc_quality"));
}

TEST_CASE("host builders take their options through the C interface, and callers may know fewer of them") {
    const Mesh mesh = clbvh::generate_scene("hair", 2000);
    const auto build_with = [&](clbvh_options options) {
        clbvh_builder* builder = nullptr;
        REQUIRE(clbvh_create_builder("median", nullptr, &options, &builder) == CLBVH_OK);
        REQUIRE(clbvh_build(builder, &mesh.vertices[0].x, mesh.vertices.size(), mesh.triangles[0].data(),
                            mesh.triangles.size()) == CLBVH_OK);
        std::uint64_t nodes = 0;
        clbvh_nodes(builder, &nodes);
        const int split = clbvh_has_split_references(builder);
        clbvh_destroy_builder(builder);
        return std::pair(nodes, split);
    };
    clbvh_options options;
    clbvh_default_options(&options, sizeof options);
    const auto plain = build_with(options);
    CHECK(plain.second == 0);
    options.max_leaf_size = 1;
    CHECK(build_with(options) == std::pair<std::uint64_t, int>(4000, 0));
    options.presplit_level = 8;
    CHECK(build_with(options).second == 1);
    options.size = offsetof(clbvh_options, inner_cost);  // all that a caller of the first layout knows
    CHECK(build_with(options) == plain);

    options.size = sizeof options;
    options.bin_count = 65;
    clbvh_builder* builder = nullptr;
    CHECK(clbvh_create_builder("binned-sah", nullptr, &options, &builder) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("bin_count is 65"));
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
        clbvh_options options;
        clbvh_default_options(&options, sizeof options);
        CHECK(options.optimizers == nullptr);
        CHECK(options.split_quota == 0.0f);
        std::string copied(ids);
        options.optimizers = copied.c_str();
        options.split_quota = 0.2f;
        options.optimize_passes = 1;
        CBuilder c;
        REQUIRE(clbvh_create_builder("binned-sah", nullptr, &options, &c.handle) == CLBVH_OK);
        copied.assign(copied.size(), '?');
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        clbvh::BuildOptions same;
        same.optimizers = ids;
        same.split_quota = 0.2f;
        same.optimize_passes = 1;
        const clbvh::Bvh expected = clbvh::build(mesh, "binned-sah", same);
        CHECK(tree_of(c.handle, 3000).nodes == expected.nodes);
        CHECK(clbvh_has_split_references(c.handle) == 1);
    }
    clbvh_options options;
    clbvh_default_options(&options, sizeof options);
    options.optimizers = "reinzert";
    CBuilder c;
    CHECK(clbvh_create_builder("lbvh", nullptr, &options, &c.handle) == CLBVH_INVALID_INPUT);
    CHECK_THAT(clbvh_last_error(), Catch::Contains("reinzert"));
}

TEST_CASE("a finished tree is improved through the C interface, within a budget") {
    const Mesh mesh = clbvh::generate_scene("city", 5000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("median", nullptr, nullptr, &c.handle) == CLBVH_OK);
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
    REQUIRE(clbvh_create_builder("sweep-sah", nullptr, nullptr, &c.handle) == CLBVH_OK);
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

TEST_CASE("callers of older layouts of the C interface keep their defaults") {
    clbvh_options options;
    clbvh_default_options(&options, sizeof options);
    options.optimizers = "unknown";
    options.split_quota = 9.0f;
    options.size = offsetof(clbvh_options, optimizers);
    CBuilder c;
    CHECK(clbvh_create_builder("median", nullptr, &options, &c.handle) == CLBVH_OK);
}
