#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "clbvh/embed.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "device/opencl/session.hpp"
#include "embed/embedded_kernels.hpp"
#include "support/builders.hpp"
#include "support/found_rays.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::uint32_t kSolid = 3;  // every third triangle is a hole

std::string options_of(TriangleTest test, const std::string& more = "") {
    return "-DCLBVH_TRIANGLE_TEST=" + std::to_string(test == TriangleTest::watertight ? 0 : 1) + " " + more;
}

/// All hits in order, of those that a filter lets count.
template <typename Filter>
std::vector<AllHits> all_hits(const Tracer& tracer, std::span<const Ray> rays, const Filter& counts) {
    const HitLists lists = tracer.all(rays);
    std::vector<AllHits> all(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        for (std::uint64_t k = lists.begins[i]; k < lists.begins[i + 1]; ++k) {
            if (counts(rays[i], lists.hits[k])) all[i].add(lists.hits[k]);
        }
    }
    return all;
}

template <typename Filter>
Embedded found_by_tracer(const Tracer& tracer, std::span<const Ray> rays, const Filter& counts) {
    Embedded found{std::vector<Hit>(rays.size()), std::vector<std::uint8_t>(rays.size()), {}};
    tracer.closest(rays, found.closest, counts);
    tracer.any(rays, found.any, counts);
    found.all = all_hits(tracer, rays, counts);
    return found;
}

void check_same(const Embedded& found, const Embedded& expected) {
    if (!device_is_exact()) {
        WARN("SKIPPED: the device does not round as the host does, so bits go unchecked");
        return;
    }
    CHECK(count_differences(found.closest, expected.closest) == 0);
    CHECK(count_differences(found.any, expected.any) == 0);
    CHECK(count_differences(found.all, expected.all) == 0);
}

/// A scene, its trees and what the host finds in it.
struct Case {
    Mesh mesh;
    Bvh bvh;
    Wide8 wide;
    std::vector<Ray> rays;

    Case(const char* scene, std::uint64_t triangles, std::size_t rays_of_each_kind)
        : mesh(generate_scene(scene, triangles)),
          bvh(build(mesh, "binned-sah")),
          wide(make_layout<Wide8>(bvh, mesh)),
          rays(difficult_rays(mesh, rays_of_each_kind)) {
        const std::vector<Ray> untraceable = untraceable_rays();
        rays.insert(rays.end(), untraceable.begin(), untraceable.end());
    }

    /// Every layout, with these options, against the host.
    void check(TriangleTest test, const std::string& options = "") const {
        const Tracer tracer(wide, {test});
        const Embedded expected = found_by_tracer(tracer, rays, [](const Ray&, const Hit&) { return true; });
        check_layouts(expected, options_of(test, options), 1);
    }
    void check_filtered(TriangleTest test) const {
        const Tracer tracer(wide, {test});
        const Embedded expected =
            found_by_tracer(tracer, rays, [](const Ray&, const Hit& hit) { return hit.primitive % kSolid != 0; });
        check_layouts(expected, options_of(test, "-DCLBVH_ACCEPT_HIT=is_solid"), kSolid);
    }

private:
    void check_layouts(const Embedded& expected, const std::string& options, std::uint32_t solid) const {
        INFO(options);
        {
            INFO("wide8");
            check_same(EmbeddedScene(wide).trace(options, rays, solid), expected);
        }
        {
            INFO("binary");
            check_same(EmbeddedScene(bvh, mesh).trace(options, rays, solid), expected);
        }
        {
            INFO("pair");
            check_same(EmbeddedScene(make_layout<PairLayout>(bvh), mesh).trace(options, rays, solid), expected);
        }
        {
            INFO("skip");
            check_same(EmbeddedScene(make_layout<SkipLayout>(bvh), mesh).trace(options, rays, solid), expected);
        }
    }
};

const TriangleTest kTests[] = {TriangleTest::watertight, TriangleTest::moller_trumbore};

/// Whether the driver compiles this version of OpenCL C.
bool speaks(const std::string& version) {
    const cl::Device device = shared_context().session().context().getInfo<CL_CONTEXT_DEVICES>().front();
    // "OpenCL C 1.2 ..."
    return device.getInfo<CL_DEVICE_OPENCL_C_VERSION>().substr(9, 3) >= version;
}

}  // namespace

TEST_CASE("embedded: the source compiles alone, in each version of the language that the device has") {
    for (const std::string version : {"1.2", "2.0", "3.0"}) {
        if (!speaks(version)) {
            WARN("SKIPPED: the device has no OpenCL C " << version);
            continue;
        }
        for (const TriangleTest test : kTests)
            CHECK(build_embedded("", options_of(test, "-Werror -cl-std=CL" + version))() != nullptr);
    }
}

TEST_CASE("embedded: hits are the tracer's, in each layout and with each test") {
    const Case scene("city", 20000, 8400);
    CHECK(scene.rays.size() > 100000);
    for (const TriangleTest test : kTests)
        scene.check(test);
}

// Hidden, since it takes long on two cores.
TEST_CASE("embedded: hits of a million rays are the tracer's", "[.million]") {
    const Case scene("clustered", 100000, 84000);
    CHECK(scene.rays.size() > 1000000);
    for (const TriangleTest test : kTests) {
        scene.check(test);
        scene.check_filtered(test);
    }
}

TEST_CASE("embedded: a filter lets hits count or not") {
    const Case scene("clustered", 5000, 500);
    for (const TriangleTest test : kTests)
        scene.check_filtered(test);
}

TEST_CASE("embedded: hits do not depend on the stack, nor on how many are asked for at once") {
    const Case scene("hair", 3000, 100);
    for (const char* options : {"-DCLBVH_STACK=1 -DCAPACITY=1", "-DCLBVH_STACK=4 -DCLBVH_STACK_LEVELS=4 -DCAPACITY=64",
                                "-DCLBVH_STACK=20 -DCLBVH_STACK_LEVELS=13", "-DCLBVH_STACK=200"})
        scene.check(TriangleTest::watertight, options);
}

TEST_CASE("embedded: an empty tree is hit by nothing") {
    const std::vector<Ray> rays(5, Ray{{0, 0, 0}, 0.0f, {1, 0, 0}});
    const Bvh bvh = build(Mesh{}, "binned-sah");
    for (const EmbeddedScene& scene : {EmbeddedScene(Wide8{}), EmbeddedScene(bvh, Mesh{}),
                                       EmbeddedScene(PairLayout{}, Mesh{}), EmbeddedScene(SkipLayout{}, Mesh{})}) {
        const Embedded found = scene.trace("", rays);
        CHECK(std::ranges::none_of(found.closest, [](const Hit& hit) { return static_cast<bool>(hit); }));
        CHECK(std::ranges::none_of(found.any, [](std::uint8_t is_hit) { return is_hit != 0; }));
        CHECK(std::ranges::none_of(found.all, [](const AllHits& all) { return all.count != 0; }));
    }
}
