#include "trace/wide_tracing.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::trace;
using simd::InstructionSet;

namespace {

Bvh build_with_leaves(const Mesh& mesh, std::uint32_t max_leaf) {
    BuildOptions options;
    options.max_leaf_size = max_leaf;
    return build(mesh, "binned-sah", options);
}

/// A filter that lets every third primitive pass.
bool is_solid(const Ray&, const Hit& hit) {
    return hit.primitive % 3 != 0;
}

std::vector<Hit> all_hits(const Wide8& tree, const Ray& ray, const WideTracing& tracing) {
    std::vector<Hit> hits;
    tracing.all(tree, ray, hits);
    return hits;
}

bool same_hits(const Wide8& tree, const Ray& ray, const WideTracing& a, const WideTracing& b) {
    return same_bits(a.closest(tree, ray), b.closest(tree, ray)) && a.any(tree, ray) == b.any(tree, ray) &&
           same_bits(a.closest_filtered(tree, ray, is_solid), b.closest_filtered(tree, ray, is_solid)) &&
           a.any_filtered(tree, ray, is_solid) == b.any_filtered(tree, ray, is_solid) &&
           std::ranges::equal(all_hits(tree, ray, a), all_hits(tree, ray, b), same_bits);
}

}  // namespace

TEST_CASE("every instruction set finds the same bits") {
    for (const char* scene : {"city", "soup", "hair", "sphere", "clustered"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        const std::vector<Ray> rays = difficult_rays(mesh, 100);
        for (const std::uint32_t max_leaf : {1u, 8u, 64u}) {
            const Bvh bvh = build_with_leaves(mesh, max_leaf);
            const Wide8 tree = make_layout<Wide8>(bvh, mesh);
            for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
                const WideTracing scalar = wide_tracing(InstructionSet::scalar, test);
                for (const InstructionSet set : simd::kInstructionSets) {
                    if (!is_available(set)) continue;
                    const WideTracing tracing = wide_tracing(set, test);
                    std::size_t differences = 0;
                    for (const Ray& ray : rays) {
                        const bool agrees = same_hits(tree, ray, tracing, scalar);
                        if (!agrees) ++differences;
                    }
                    INFO(scene << ", leaves of " << max_leaf << ", set " << simd::to_string(set));
                    CHECK(differences == 0);
                }
            }
        }
    }
}
