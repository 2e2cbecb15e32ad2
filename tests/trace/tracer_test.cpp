#include "clbvh/trace/tracer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/host/presplit.hpp"
#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"
#include "support/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

struct Tree {
    std::string name;
    Bvh bvh;
};

/// What every host builder makes of the mesh, with leaves of one and of several triangles, and with split triangles.
std::vector<Tree> host_trees(const Mesh& mesh) {
    std::vector<Tree> trees;
    for (const BuilderInfo& info : builders()) {
        if (info.kind != BuilderKind::host) continue;
        for (const auto& [presplit, max_leaf] : {std::pair{0u, 0u}, std::pair{0u, 8u}, std::pair{14u, 4u}}) {
            BuildOptions options;
            options.presplit_level = presplit;
            options.max_leaf_size = max_leaf;
            trees.push_back(
                {std::string(info.id) + (presplit > 0 ? " presplit" : "") + " leaves of " + std::to_string(max_leaf),
                 build(mesh, info.id, options)});
        }
    }
    return trees;
}

/// How many of the rays get another closest hit, or another answer from any(), than without a tree.
std::size_t count_differences(const Tracer& tracer, std::span<const Ray> rays, std::span<const Hit> expected) {
    std::size_t differences = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        RayCounts counts;
        const bool agrees = same_bits(tracer.closest(rays[i]), expected[i]) &&
                            same_bits(tracer.closest(rays[i], counts), expected[i]) &&
                            tracer.any(rays[i]) == static_cast<bool>(expected[i]);
        if (!agrees) ++differences;
    }
    return differences;
}

std::vector<Hit> closest_without_tree(const Mesh& mesh, std::span<const Ray> rays, TriangleTest test) {
    std::vector<Hit> hits;
    for (const Ray& ray : rays)
        hits.push_back(brute_force_closest(mesh, ray, test));
    return hits;
}

}  // namespace

TEST_CASE("the closest hit does not depend on the tree, and any() tells whether there is one") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        const Mesh mesh = generate_scene(scene.name, 300);
        const std::vector<Ray> rays = difficult_rays(mesh, 40);
        const std::vector<Tree> trees = host_trees(mesh);
        for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
            const std::vector<Hit> expected = closest_without_tree(mesh, rays, test);
            for (const Tree& tree : trees) {
                INFO(scene.name << ", " << tree.name << ", test " << static_cast<int>(test));
                CHECK(count_differences(Tracer(tree.bvh, mesh, {test}), rays, expected) == 0);
            }
        }
    }
}
