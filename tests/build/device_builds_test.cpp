// What Builder promises of builders that run on a device.
#include <catch2/catch.hpp>
#include <limits>

#include "clbvh/builder.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// Fails a build after `calls` calls of the progress callback.
struct Canceller {
    std::size_t calls = 0;
    std::size_t allowed = std::numeric_limits<std::size_t>::max();

    [[nodiscard]] ProgressCallback callback() {
        return [this](const Progress&) { return calls++ < allowed; };
    }
};

}  // namespace

TEST_CASE("building again gives the same bytes, in both shapes") {
    for (const std::string_view scene : {"soup", "particles", "hair"}) {
        const Mesh mesh = generate_scene(scene, 30000);
        for (const std::string_view id : device_builders()) {
            INFO(id << " on " << scene);
            Builder group = make_builder(id, options_of(Shape::group));
            Builder lane = make_builder(id, options_of(Shape::lane));
            const Bvh first = group.build(mesh);
            CHECK(same_bytes(group.build(mesh), first));
            CHECK(same_bytes(lane.build(mesh), first));
            CHECK(same_bytes(lane.build(mesh), first));
            CHECK(same_bytes(make_builder(id, options_of(Shape::group)).build(mesh), first));
        }
    }
}

TEST_CASE("one builder takes meshes that grow and shrink") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            Builder builder = make_builder(id, options_of(shape));
            for (const std::uint32_t size : {10u, 5000u, 3u, 0u, 70000u, 1u, 5000u, 2u, 70001u}) {
                const Mesh mesh = generate_scene("soup", size);
                if (!expect_oracle_tree(builder, builder.build(mesh), mesh, std::to_string(size))) break;
            }
        }
    }
}

TEST_CASE("progress rises, and a build can be cancelled at every call") {
    const Mesh mesh = generate_scene("clustered", 20000);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::string_view id : device_builders()) {
            INFO(id << ", " << to_string(shape));
            BuildOptions options = options_of(shape);
            options.ploc.single_group_threshold = 1000;
            const Bvh expected = make_builder(id, options).build(mesh);

            Canceller canceller;
            double last = 0.0;
            const ProgressCallback count = canceller.callback();
            options.progress = [&](const Progress& progress) {
                CHECK(progress.fraction >= last);
                CHECK(progress.fraction <= 1.0);
                CHECK_FALSE(progress.stage.empty());
                last = progress.fraction;
                return count(progress);
            };
            Builder builder = make_builder(id, options);
            CHECK(same_bytes(builder.build(mesh), expected));
            CHECK(last > 0.5);
            const std::size_t calls = canceller.calls;
            CHECK(calls >= 5);

            for (std::size_t allowed = 0; allowed < calls; ++allowed) {
                last = 0.0;
                canceller = {0, allowed};
                expect_error(ErrorCode::cancelled, {}, [&] { (void)builder.build(mesh); });
                CHECK(canceller.calls == allowed + 1);
            }
            expect_error(ErrorCode::invalid_input, {"run"}, [&] { (void)builder.download(); });
            last = 0.0;
            canceller = {};
            CHECK(same_bytes(builder.build(mesh), expected));
        }
    }
}

TEST_CASE("an exception of the progress callback leaves the build, and the builder still works") {
    struct Stop {};
    bool stop = true;
    BuildOptions options = options_of(Shape::lane);
    options.progress = [&](const Progress&) -> bool {
        if (stop) throw Stop{};
        return true;
    };
    const Mesh mesh = random_triangles(1000);
    for (const std::string_view id : device_builders()) {
        Builder builder = make_builder(id, options);
        stop = true;
        CHECK_THROWS_AS(builder.build(mesh), Stop);
        stop = false;
        expect_oracle_tree(builder, builder.build(mesh), mesh, "after an exception");
    }
}

TEST_CASE("the builder says what it is") {
    for (const std::string_view id : device_builders()) {
        CHECK(make_builder(id, options_of(Shape::group)).shape() == Shape::group);
        CHECK(make_builder(id, options_of(Shape::lane)).shape() == Shape::lane);
        const Builder builder = make_builder(id);
        CHECK(builder.info().id == id);
        CHECK(builder.options().ploc.search_radius == 16);
        const Shape chosen = shared_context().prefers_lane_shape() ? Shape::lane : Shape::group;
        CHECK(builder.shape() == chosen);
        CHECK(builder.context().opencl_queue() == shared_context().opencl_queue());
    }
}

TEST_CASE("builders can be moved") {
    const Mesh mesh = random_triangles(500);
    Builder first = make_builder("plocpp", options_of(Shape::lane));
    const Bvh expected = first.build(mesh);
    Builder second = std::move(first);
    CHECK(same_bytes(second.build(mesh), expected));
    Builder third = make_builder("lbvh");
    third = std::move(second);
    CHECK(same_bytes(third.build(mesh), expected));
}

TEST_CASE("one call builds on the default device") {
    const Mesh mesh = random_triangles(500);
    BuildStats stats;
    CHECK(validate(build(mesh), mesh).valid);
    CHECK(validate(build(mesh, "lbvh", {}, &stats), mesh).valid);
    CHECK(stats.launches > 0);
}

TEST_CASE("a tree is built on the caller's queue") {
    const Mesh mesh = random_triangles(2000);
    const Context own = Context::open();
    Builder builder("plocpp", Context::adopt(own.opencl_queue()), options_of(Shape::lane));
    CHECK(builder.context().opencl_queue() == own.opencl_queue());
    CHECK(same_bytes(builder.build(mesh), make_builder("plocpp", options_of(Shape::lane)).build(mesh)));
}

TEST_CASE("options of device builders out of range are refused at construction") {
    BuildOptions options;
    options.ploc.search_radius = 33;
    for (const std::string_view id : device_builders()) {
        expect_error(ErrorCode::invalid_input, {"search_radius is 33"}, [&] { (void)make_builder(id, options); });
    }
    options = options_of(Shape::group, 32);
    options.ploc.work_group_size = 128;
    expect_error(ErrorCode::invalid_input, {"work_group_size 128", "search_radius"},
                 [&] { (void)make_builder("plocpp", options); });
}
