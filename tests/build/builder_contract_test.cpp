// What Builder promises beside the tree itself: the same bytes every time, errors, progress, reuse, statistics.
#include <catch2/catch.hpp>
#include <limits>

#include "clbvh/builder.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Calls `check` with a builder of each device row in each shape.
template <typename Check>
void for_each_device_builder(Check check) {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            INFO(id << ", " << to_string(shape));
            Builder builder = make_builder(id, options_of(shape));
            check(builder);
        }
    }
}

/// Calls `check` with a builder of each host row as well.
template <typename Check>
void for_each_builder(Check check) {
    for_each_device_builder(check);
    for (const std::string_view id : host_builders()) {
        INFO(id);
        Builder builder{id};
        check(builder);
    }
}

}  // namespace

TEST_CASE("upload, run and download are build in three steps") {
    const Mesh mesh = generate_scene("soup", 3000);
    for_each_builder([&](Builder& builder) {
        const Bvh expected = builder.build(mesh);
        builder.upload(mesh);
        CHECK(builder.run().build_ms > 0.0);
        CHECK(same_bytes(builder.download(), expected));
        CHECK(builder.run().build_ms > 0.0);
        CHECK(same_bytes(builder.download(), expected));
        CHECK(same_bytes(builder.download(), expected));
        CHECK(same_bytes(builder.build(mesh), expected));
        expect_error(ErrorCode::invalid_input, {"upload"}, [&] { (void)builder.run(); });
        CHECK(same_bytes(builder.download(), expected));
        builder.upload(Mesh(mesh));  // which the builder has to keep
        builder.run();
        CHECK(same_bytes(builder.download(), expected));
    });
}

TEST_CASE("steps out of order are errors") {
    for_each_builder([](Builder& builder) {
        expect_error(ErrorCode::invalid_input, {"upload"}, [&] { (void)builder.run(); });
        expect_error(ErrorCode::invalid_input, {"run"}, [&] { (void)builder.download(); });
        builder.upload(random_triangles(10));
        expect_error(ErrorCode::invalid_input, {"run"}, [&] { (void)builder.download(); });
    });
}

TEST_CASE("a mesh that breaks the contract is refused, and the builder still works") {
    const Mesh sound = random_triangles(100);
    Mesh bad_index = sound;
    bad_index.triangles[40][1] = 300;
    Mesh infinite = sound;
    infinite.vertices[33].y = -kInfinity;
    Mesh too_far = sound;
    too_far.vertices[299].z = 1.1e18f;
    for_each_builder([&](Builder& builder) {
        const Bvh expected = builder.build(sound);
        expect_error(ErrorCode::invalid_input, {"triangle 40: vertex index 300 is out of range"},
                     [&] { (void)builder.build(bad_index); });
        expect_error(ErrorCode::invalid_input, {"triangle 11: coordinate y of vertex 33 is -inf"},
                     [&] { (void)builder.build(infinite); });
        expect_error(ErrorCode::invalid_input, {"triangle 99: coordinate z of vertex 299"},
                     [&] { (void)builder.build(too_far); });
        CHECK(same_bytes(builder.build(sound), expected));
    });
}

TEST_CASE("unknown builders are refused at construction") {
    expect_error(ErrorCode::invalid_input, {"plok", "ploc", "plocpp", "plocpp-two-level", "hploc", "lbvh"},
                 [] { (void)make_builder("plok"); });
}

TEST_CASE("one host builder takes meshes that grow and shrink") {
    for (const std::string_view id : host_builders()) {
        INFO(id);
        Builder kept{id};
        for (const std::uint32_t size : {10u, 5000u, 3u, 0u, 30000u, 1u, 5000u, 2u, 30001u}) {
            const Mesh mesh = generate_scene("soup", size);
            const Bvh bvh = kept.build(mesh);
            CHECK(validate(bvh, mesh).error == "");
            CHECK(same_bytes(Builder(id).build(mesh), bvh));
        }
    }
}

TEST_CASE("progress of host builders rises, and a build can be cancelled") {
    const Mesh mesh = generate_scene("clustered", 20000);
    for (const std::string_view id : host_builders()) {
        INFO(id);
        const Bvh expected = Builder(id).build(mesh);
        std::size_t allowed = std::numeric_limits<std::size_t>::max(), calls = 0;
        double last = 0.0;
        BuildOptions options;
        options.progress = [&](const Progress& progress) {
            CHECK(progress.fraction >= last);
            CHECK(progress.fraction <= 1.0);
            CHECK_FALSE(progress.stage.empty());
            last = progress.fraction;
            return calls++ < allowed;
        };
        Builder builder(id, options);
        CHECK(same_bytes(builder.build(mesh), expected));
        CHECK(last > 0.5);
        // How often it is called depends on time, but each of the stages begins with a call.
        CHECK(calls >= 3);
        for (allowed = 0; allowed < 3; ++allowed) {
            last = 0.0;
            calls = 0;
            expect_error(ErrorCode::cancelled, {}, [&] { (void)builder.build(mesh); });
            CHECK(calls == allowed + 1);
            expect_error(ErrorCode::invalid_input, {"run"}, [&] { (void)builder.download(); });
        }
        allowed = std::numeric_limits<std::size_t>::max();
        last = 0.0;
        CHECK(same_bytes(builder.build(mesh), expected));
    }
}
