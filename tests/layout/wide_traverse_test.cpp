#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/traverse.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/hard_trees.hpp"
#include "support/oracle/ray_oracle.hpp"
#include "trace/leaf_triangles.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::trace;

namespace {

/// Leaf code of a caller's own: the library's rule, written for single triangles.
template <std::uint32_t Width>
Hit closest(const WideLayout<Width>& layout, const Ray& ray) {
    const WatertightTest test(ray);
    const HitRule rule(ray);
    Hit closest;
    traverse(layout, ray, [&](std::span<const TriangleBlock> blocks, float& t_max) {
        for (const TriangleBlock& block : blocks) {
            const auto vertex = [&](std::size_t lane, std::size_t i) {
                const auto& [x, y, z] = block.vertices[i];
                return Vec3{x[lane], y[lane], z[lane]};
            };
            for (std::size_t lane = 0; lane < kBlockTriangles; ++lane) {
                const TriangleVertices triangle{vertex(lane, 0), vertex(lane, 1), vertex(lane, 2)};
                const auto found = rule.accept(triangle, test.meet(triangle));
                if (!found || !is_closer(found->t, block.primitives[lane], closest)) continue;
                closest = {found->t, found->u, found->v, block.primitives[lane]};
                t_max = found->t;
            }
        }
        return true;
    });
    return closest;
}

}  // namespace

TEST_CASE("leaf code of one's own finds the tracer's hits through layouts of either width") {
    for (const char* name : {"city", "hair"}) {
        const Mesh mesh = generate_scene(name, 3000);
        const Bvh bvh = build(mesh, "binned-sah");
        const auto wide8 = make_layout<Wide8>(bvh, mesh);
        const auto wide4 = make_layout<Wide4>(bvh, mesh);
        const Tracer tracer(wide8);
        std::size_t differences = 0, hits = 0;
        for (const Ray& ray : difficult_rays(mesh, 200)) {
            const Hit expected = tracer.closest(ray);
            hits += expected ? 1 : 0;
            if (!same_bits(closest(wide8, ray), expected) || !same_bits(closest(wide4, ray), expected)) ++differences;
        }
        INFO(name);
        CHECK(differences == 0);
        CHECK(hits > 500);
    }
}

TEST_CASE("a traversal of a layout visits near leaves first, and ends where its caller says so") {
    const Mesh mesh = generate_scene("soup", 5000);
    const auto layout = make_layout<Wide8>(build(mesh, "binned-sah"), mesh);
    std::size_t all = 0, until_closest = 0, until_any = 0;
    for (const Ray& ray : difficult_rays(mesh, 30)) {
        std::set<const TriangleBlock*> seen;
        traverse(layout, ray, [&](std::span<const TriangleBlock> blocks, float&) {
            all += blocks.size();
            for (const TriangleBlock& block : blocks)
                CHECK(seen.insert(&block).second);
            return true;
        });
        const Tracer tracer(layout);
        const float nearest = tracer.closest(ray).t;
        traverse(layout, ray, [&](std::span<const TriangleBlock> blocks, float& t_max) {
            until_closest += blocks.size();
            t_max = std::min(t_max, nearest);
            return true;
        });
        traverse(layout, ray, [&](std::span<const TriangleBlock>, float&) {
            ++until_any;
            return false;
        });
    }
    CHECK(until_any > 0);
    CHECK(until_any * 2 < until_closest);
    CHECK(until_closest * 5 < all * 4);
}

TEST_CASE("a traversal of a layout takes any depth, and visits nothing of none") {
    const Mesh mesh = generate_scene("soup", 20000);
    const auto layout = make_layout<Wide8>(chain_tree(mesh), mesh);
    CHECK(layout.depth > 1000);
    const Tracer tracer(layout);
    for (const Ray& ray : difficult_rays(mesh, 2))
        CHECK(same_bits(closest(layout, ray), tracer.closest(ray)));

    const auto fail = [](std::span<const TriangleBlock>, float&) {
        FAIL("visited");
        return true;
    };
    traverse(Wide8{}, {{0, 0, 0}, 0.0f, {1, 0, 0}}, fail);
    for (const Ray& ray : untraceable_rays())
        traverse(layout, ray, fail);
}
