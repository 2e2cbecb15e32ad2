#include "trace/wide_tracing.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

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

/// Walks a wide tree: every box contains what is below it, and every primitive is found.
class WideTreeCheck {
public:
    explicit WideTreeCheck(const WideTree& tree) : tree_(tree) {}

    std::string run() {
        visit_node(0, 1, {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}});
        if (depth != tree_.depth) fault = "wrong depth";
        return fault;
    }
    std::set<std::uint32_t> primitives;
    std::size_t blocks = 0;
    std::uint32_t depth = 0;
    std::string fault;

private:
    static bool contains(const Aabb& outer, const Aabb& inner) { return merge(outer, inner) == outer; }

    void visit_node(std::uint32_t index, std::uint32_t level, const Aabb& outer) {
        const WideNode& node = tree_.nodes[index];
        depth = std::max(depth, level);
        for (std::uint32_t slot = 0; slot < kWideChildren; ++slot) {
            const auto corner = [&](std::size_t side) {
                return Vec3{node.bounds[side][0][slot], node.bounds[side][1][slot], node.bounds[side][2][slot]};
            };
            const Aabb box{corner(0), corner(1)};
            if (box == Aabb{}) continue;
            if (!contains(outer, box)) fault = "a box is not within its parent's";
            const std::uint32_t child = node.children[slot];
            if ((child & kLeafFlag) != 0) {
                visit_leaf(child & ~kLeafFlag, box);
            } else {
                visit_node(child, level + 1, box);
            }
        }
    }

    void visit_leaf(std::uint32_t index, const Aabb& outer) {
        for (;; ++index) {
            const TriangleBlock& block = tree_.blocks[index];
            ++blocks;
            for (std::uint32_t lane = 0; lane < kBlockTriangles; ++lane) {
                const TriangleVertices triangle = block.triangle(lane);
                if (std::isnan(triangle.v0.x)) continue;
                primitives.insert(block.primitive(lane));
                for (const Vec3& vertex : {triangle.v0, triangle.v1, triangle.v2})
                    if (!contains(outer, {vertex, vertex})) fault = "a vertex is not in its leaf's box";
            }
            if (block.is_last()) return;
        }
    }

    const WideTree& tree_;
};

}  // namespace

TEST_CASE("a wide tree holds all triangles of the binary one, within its boxes") {
    for (const std::uint64_t count : {1u, 4u, 5u, 9u, 33u, 4000u}) {
        const Mesh mesh = generate_scene("hair", count);
        for (const std::uint32_t max_leaf : {1u, 3u, 8u, 64u}) {
            const Bvh bvh = build_with_leaves(mesh, max_leaf);
            const WideTree tree = make_wide_tree(bvh.nodes, copy_triangles(bvh, mesh));
            WideTreeCheck check(tree);
            INFO(count << " triangles, leaves of " << max_leaf);
            CHECK(check.run().empty());
            CHECK(check.primitives.size() == count);
            CHECK(check.blocks == tree.blocks.size());
        }
    }
}

TEST_CASE("every instruction set finds the same bits") {
    for (const char* scene : {"city", "soup", "hair", "sphere", "clustered"}) {
        const Mesh mesh = generate_scene(scene, 3000);
        const std::vector<Ray> rays = difficult_rays(mesh, 100);
        for (const std::uint32_t max_leaf : {1u, 8u, 64u}) {
            const Bvh bvh = build_with_leaves(mesh, max_leaf);
            const WideTree tree = make_wide_tree(bvh.nodes, copy_triangles(bvh, mesh));
            for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
                const WideTracing scalar = wide_tracing(InstructionSet::scalar, test);
                for (const InstructionSet set : simd::kInstructionSets) {
                    if (!is_available(set)) continue;
                    const WideTracing tracing = wide_tracing(set, test);
                    std::size_t differences = 0;
                    for (const Ray& ray : rays) {
                        const bool agrees = same_bits(tracing.closest(tree, ray), scalar.closest(tree, ray)) &&
                                            tracing.any(tree, ray) == scalar.any(tree, ray);
                        if (!agrees) ++differences;
                    }
                    INFO(scene << ", leaves of " << max_leaf << ", set " << simd::to_string(set));
                    CHECK(differences == 0);
                }
            }
        }
    }
}
