// The C interface with builders that run on a device.
#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "clbvh/clbvh.h"
#include "clbvh/clbvh.hpp"
#include "clbvh/io/scene.hpp"
#include "support/c_builder.hpp"

extern "C" int clbvh_c_consumer(void);

namespace {

using clbvh::Mesh;
using clbvh::test::build;
using clbvh::test::CBuilder;

int stop_at_once(void* user, const char* stage, double fraction) {
    *static_cast<std::string*>(user) = stage;
    return fraction < 0.0 ? 1 : 0;
}

}  // namespace

TEST_CASE("the C interface gives the C++ interface's tree") {
    const Mesh mesh = clbvh::generate_scene("clustered", 3000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("plocpp", nullptr, &c.handle) == CLBVH_OK);
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

TEST_CASE("the C interface works from a C program") {
    CHECK(clbvh_c_consumer() == 0);
}

TEST_CASE("a failed build through the C interface leaves no tree and a builder that works") {
    CBuilder c;
    REQUIRE(clbvh_create_builder("lbvh", "", &c.handle) == CLBVH_OK);
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

TEST_CASE("progress through the C interface names the stage and cancels") {
    std::string stage;
    CBuilder c;
    REQUIRE(clbvh_create_builder("plocpp", nullptr, &c.handle) == CLBVH_OK);
    REQUIRE(clbvh_set_progress(c.handle, stop_at_once, &stage) == CLBVH_OK);
    CHECK(build(c.handle, clbvh::generate_scene("soup", 100)) == CLBVH_CANCELLED);
    CHECK(stage == "bounds");
    REQUIRE(clbvh_set_progress(c.handle, nullptr, nullptr) == CLBVH_OK);
    CHECK(build(c.handle, clbvh::generate_scene("soup", 100)) == CLBVH_OK);
    CHECK(clbvh_set_progress(nullptr, stop_at_once, &stage) == CLBVH_INVALID_INPUT);
}

TEST_CASE("what is set through the C interface is what the next build follows") {
    const Mesh mesh = clbvh::generate_scene("soup", 2000);
    CBuilder c;
    REQUIRE(clbvh_create_builder("hploc", nullptr, &c.handle) == CLBVH_OK);
    clbvh::BuildOptions same;
    const auto expect_same = [&] {
        REQUIRE(build(c.handle, mesh) == CLBVH_OK);
        const clbvh::Bvh expected = clbvh::build(mesh, "hploc", same);
        std::uint64_t count = 0;
        const clbvh_node* nodes = clbvh_nodes(c.handle, &count);
        REQUIRE(count == expected.nodes.size());
        CHECK(std::memcmp(nodes, expected.nodes.data(), count * sizeof(clbvh_node)) == 0);
    };
    expect_same();
    REQUIRE(clbvh_set_option(c.handle, "device.code_bits", "33") == CLBVH_OK);
    REQUIRE(clbvh_set_option(c.handle, "hploc.small_range", "256") == CLBVH_OK);
    same.device.code_bits = 33;
    same.hploc.small_range = 256;
    expect_same();
    CHECK(std::string(clbvh_get_option(c.handle, "hploc.small_range")) == "256");
    REQUIRE(clbvh_set_option(c.handle, "max_leaf_size", "4") == CLBVH_OK);
    same.max_leaf_size = 4;
    expect_same();
}

TEST_CASE("a device that there is not is told through the C interface") {
    CBuilder c;
    CHECK(clbvh_create_builder("plocpp", "no such device", &c.handle) == CLBVH_NO_DEVICE);
    CHECK(c.handle == nullptr);
}
