#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "clbvh/embed.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "device/opencl/session.hpp"
#include "embed/embedded_kernels.hpp"
#include "support/builders.hpp"
#include "support/found_rays.hpp"
#include "support/hard_trees.hpp"
#include "support/layout_trees.hpp"
#include "support/meshes.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::size_t kMillion = 1000000;

const TriangleTest kTests[] = {TriangleTest::watertight, TriangleTest::moller_trumbore};

std::string options_of(TriangleTest test, const std::string& more = "") {
    return "-DCLBVH_TRIANGLE_TEST=" + std::to_string(test == TriangleTest::watertight ? 0 : 1) + " " + more;
}

/// What the kernels' pattern of holes lets count: see there. user[0][0] is `kPeriod`.
constexpr std::uint32_t kPeriod = 3;
bool is_solid(const Ray&, const Hit& hit) {
    const auto column = static_cast<std::uint32_t>(hit.u * 8.0f), row = static_cast<std::uint32_t>(hit.v * 8.0f);
    return (column + row + hit.primitive) % kPeriod != 0;
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

/// A tree, rays, and what the host finds there.
class Case {
public:
    Case(Mesh mesh, Bvh bvh, std::vector<Ray> rays)
        : mesh_(std::move(mesh)), bvh_(std::move(bvh)), rays_(std::move(rays)) {}
    Case(const char* scene, std::uint64_t triangles, std::string_view builder, std::size_t ray_count)
        : mesh_(generate_scene(scene, triangles)),
          bvh_(built_tree(builder, mesh_)),
          rays_(difficult_rays(mesh_, ray_count / 12)) {
        const std::vector<Ray> untraceable = untraceable_rays();
        rays_.insert(rays_.end(), untraceable.begin(), untraceable.end());
    }

    /// Every layout, with these options, against the host.
    void check(TriangleTest test, const std::string& options = "") const {
        const Tracer tracer(bvh_, mesh_, {test});
        const auto every = [](const Ray&, const Hit&) { return true; };
        check_layouts(found_by_tracer(tracer, rays_, every), options_of(test, options), {});
    }
    void check_filtered(TriangleTest test) const {
        const Tracer tracer(bvh_, mesh_, {test});
        check_layouts(found_by_tracer(tracer, rays_, is_solid), options_of(test, "-DCLBVH_ACCEPT_HIT=is_solid"),
                      {{float{kPeriod}}});
    }

private:
    void check_layouts(const Embedded& expected, const std::string& options, const User& user) const {
        INFO(options);
        for (const EmbeddedScene& scene : embedded_scenes(bvh_, mesh_)) {
            INFO(scene.layout());
            check_same(scene.trace(options, rays_, user), expected);
        }
    }

    Mesh mesh_;
    Bvh bvh_;
    std::vector<Ray> rays_;
};

/// Whether the driver compiles this version of OpenCL C: "1.2".
bool speaks(const std::string& version) {
    const cl::Device device = shared_context().session().context().getInfo<CL_CONTEXT_DEVICES>().front();
    // Since OpenCL 3.0 a device lists them all, as cl_name_version: the major number above bit 22, the minor above 12.
    struct NameAndVersion {
        cl_uint version;
        std::array<char, 64> name;
    };
    constexpr cl_device_info kAllVersions = 0x1066;  // CL_DEVICE_OPENCL_C_ALL_VERSIONS
    std::size_t size = 0;
    if (clGetDeviceInfo(device(), kAllVersions, 0, nullptr, &size) != CL_SUCCESS) {
        // "OpenCL C 1.2 ..."
        return device.getInfo<CL_DEVICE_OPENCL_C_VERSION>().substr(9, 3) >= version;
    }
    std::vector<NameAndVersion> all(size / sizeof(NameAndVersion));
    clGetDeviceInfo(device(), kAllVersions, size, all.data(), nullptr);
    return std::ranges::any_of(all, [&](const NameAndVersion& one) {
        return std::to_string(one.version >> 22U) + "." + std::to_string(one.version >> 12U & 0x3FFU) == version;
    });
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
    const Case scene("city", 20000, "binned-sah", 20000);
    for (const TriangleTest test : kTests)
        scene.check(test);
}

TEST_CASE("embedded: hits are the tracer's, in trees of each kind") {
    for (const char* builder : {"ploc", "hploc", "lbvh", "sbvh", "aac-fast", "median"}) {
        for (const char* scene : {"hair", "clustered"}) {
            INFO(builder << ", " << scene);
            Case(scene, 3000, builder, 1200).check(TriangleTest::watertight);
        }
    }
}

TEST_CASE("embedded: hits are the tracer's, in odd trees") {
    for (const MeshTree& tree : odd_trees()) {
        if (tree.bvh.nodes.empty()) continue;
        INFO(tree.name);
        Case(tree.mesh, tree.bvh, difficult_rays(tree.mesh, 20)).check(TriangleTest::watertight);
    }
}

// These are hidden, since they take minutes.
TEST_CASE("embedded: hits of a million rays are the tracer's", "[.million]") {
    Case("city", 20000, "binned-sah", kMillion).check(TriangleTest::watertight, "-DCAPACITY=16");
}

TEST_CASE("embedded: hits of a million rays are the tracer's where triangles were split", "[.million]") {
    Case("city", 20000, "sbvh", kMillion).check(TriangleTest::moller_trumbore, "-DCAPACITY=16");
}

TEST_CASE("embedded: hits of a million rays are the tracer's behind a filter", "[.million]") {
    Case("hair", 5000, "hploc", kMillion).check_filtered(TriangleTest::watertight);
}

TEST_CASE("embedded: a filter lets hits count or not") {
    Case("clustered", 5000, "binned-sah", 6000).check_filtered(TriangleTest::watertight);
}

TEST_CASE("embedded: hits do not depend on the stack, nor on how many are asked for at once") {
    const Case scene("hair", 3000, "binned-sah", 1200);
    for (const char* options :
         {"-DCLBVH_STACK=1 -DCAPACITY=1", "-DCLBVH_STACK=20 -DCLBVH_STACK_LEVELS=8 -DCAPACITY=64"})
        scene.check(TriangleTest::watertight, options);
}

TEST_CASE("embedded: a chain deeper than any stack is searched to its end") {
    const Mesh mesh = random_triangles(3000);
    Case(mesh, chain_tree(mesh), difficult_rays(mesh, 30)).check(TriangleTest::watertight);
}

TEST_CASE("embedded: compressed8 without the mesh finds the same hits, but for the rounding of its triangles") {
    const Mesh mesh = generate_scene("city", 5000);
    const Bvh bvh = build(mesh, "binned-sah");
    std::vector<Ray> rays;
    for (std::size_t i = 0; const Ray& ray : difficult_rays(mesh, 1000)) {
        // Those between any points: others aim at vertices and edges, or begin on triangles.
        if (const std::size_t kind = i++ % 12; kind < 2 || kind == 9 || kind == 10) rays.push_back(ray);
    }
    for (const TriangleTest test : kTests) {
        const Tracer tracer(bvh, mesh, {test});
        const Embedded found = EmbeddedScene(make_layout<Compressed8>(bvh, mesh)).trace(options_of(test), rays);
        std::size_t hits = 0, others = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Hit expected = tracer.closest(rays[i]);
            hits += expected ? 1 : 0;
            const float difference = std::abs(found.closest[i].t - expected.t);
            const bool is_same = found.closest[i].primitive == expected.primitive &&
                                 (!expected || difference <= 1e-4f * (1.0f + expected.t));
            others += is_same && (found.any[i] != 0) == static_cast<bool>(expected) ? 0 : 1;
        }
        INFO("test " << static_cast<int>(test));
        CHECK(hits > 500);
        CHECK(others <= 2);
    }
}

TEST_CASE("embedded: an empty tree is hit by nothing") {
    const std::vector<Ray> rays(5, Ray{{0, 0, 0}, 0.0f, {1, 0, 0}});
    for (const EmbeddedScene& scene : embedded_scenes(build(Mesh{}, "binned-sah"), Mesh{})) {
        INFO(scene.layout());
        const Embedded found = scene.trace(options_of(TriangleTest::watertight), rays);
        CHECK(std::ranges::none_of(found.closest, [](const Hit& hit) { return static_cast<bool>(hit); }));
        CHECK(std::ranges::none_of(found.any, [](std::uint8_t is_hit) { return is_hit != 0; }));
        CHECK(std::ranges::none_of(found.all, [](const AllHits& all) { return all.count != 0; }));
    }
}
