#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/traverse.hpp"
#include "clbvh/trace/binary_tracer.hpp"
#include "support/hard_trees.hpp"
#include "support/layout_trees.hpp"
#include "support/oracle/ray_oracle.hpp"
#include "trace/leaf_triangles.hpp"

using namespace clbvh;
using namespace clbvh::test;
using namespace clbvh::trace;

namespace {

/// Leaf code of a caller's own for one triangle of a mesh: the library's rule.
class ClosestSearch {
public:
    ClosestSearch(const Mesh& mesh, const Ray& ray) : mesh_(mesh), test_(ray), rule_(ray) {}

    void look_at(std::uint32_t primitive, float& t_max) {
        const auto& [a, b, c] = mesh_.triangles[primitive];
        const TriangleVertices triangle{mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]};
        const auto found = rule_.accept(triangle, test_.meet(triangle));
        if (!found || !is_closer(found->t, primitive, hit_)) return;
        hit_ = {found->t, found->u, found->v, primitive};
        t_max = found->t;
    }
    [[nodiscard]] const Hit& hit() const noexcept { return hit_; }

private:
    const Mesh& mesh_;
    WatertightTest test_;
    HitRule rule_;
    Hit hit_;
};

/// Calls visit(primitives, t_max) for each leaf.
template <typename Layout, typename Visit>
void traverse_primitives(const Layout& layout, const Ray& ray, Visit visit) {
    traverse(layout, ray, [&](std::uint32_t first, std::uint32_t count, float& t_max) {
        const std::uint32_t* const ids = layout.primitive_ids.data() + first;
        return visit(std::vector<std::uint32_t>(ids, ids + count), t_max);
    });
}
template <typename Visit>
void traverse_primitives(const Compressed8& layout, const Ray& ray, Visit visit) {
    traverse(layout, ray, [&](std::span<const Compressed8Triangle> triangles, float& t_max) {
        std::vector<std::uint32_t> primitives;
        for (const Compressed8Triangle& triangle : triangles)
            primitives.push_back(triangle.primitive);
        return visit(primitives, t_max);
    });
}

template <typename Layout>
Hit closest(const Layout& layout, const Mesh& mesh, const Ray& ray) {
    ClosestSearch search(mesh, ray);
    traverse_primitives(layout, ray, [&](const std::vector<std::uint32_t>& primitives, float& t_max) {
        for (const std::uint32_t primitive : primitives)
            search.look_at(primitive, t_max);
        return true;
    });
    return search.hit();
}

/// How many rays hit something else than in the binary tree.
std::size_t count_others(const MeshTree& tree, std::span<const Ray> rays) {
    const BinaryTracer tracer(tree.bvh, tree.mesh);
    const auto pair = make_layout<PairLayout>(tree.bvh);
    const auto skip = make_layout<SkipLayout>(tree.bvh);
    const auto compressed8 = make_layout<Compressed8>(tree.bvh, tree.mesh);
    std::size_t others = 0;
    for (const Ray& ray : rays) {
        RayCounts counts;
        const Hit expected = tracer.closest(ray, counts);
        others += same_bits(closest(pair, tree.mesh, ray), expected) ? 0 : 1;
        others += same_bits(closest(skip, tree.mesh, ray), expected) ? 0 : 1;
        others += same_bits(closest(compressed8, tree.mesh, ray), expected) ? 0 : 1;
    }
    return others;
}

struct Visits {
    std::size_t all = 0, until_closest = 0, until_any = 0;
};

/// Primitives that rays visit, each at most once.
template <typename Layout>
Visits count_visits(const Layout& layout, const Mesh& mesh, std::span<const Ray> rays) {
    Visits visits;
    for (const Ray& ray : rays) {
        std::set<std::uint32_t> seen;
        traverse_primitives(layout, ray, [&](const std::vector<std::uint32_t>& primitives, float&) {
            for (const std::uint32_t primitive : primitives)
                CHECK(seen.insert(primitive).second);
            return true;
        });
        visits.all += seen.size();
        const float nearest = closest(layout, mesh, ray).t;
        traverse_primitives(layout, ray, [&](const std::vector<std::uint32_t>& primitives, float& t_max) {
            visits.until_closest += primitives.size();
            t_max = std::min(t_max, nearest);
            return true;
        });
        traverse_primitives(layout, ray, [&](const std::vector<std::uint32_t>& primitives, float&) {
            visits.until_any += primitives.size();
            return false;
        });
    }
    return visits;
}

}  // namespace

TEST_CASE("leaf code of one's own finds the binary tree's hits through pair, skip and compressed layouts") {
    for (const char* name : {"city", "hair"}) {
        const Mesh mesh = generate_scene(name, 1000);
        const std::vector<Ray> rays = difficult_rays(mesh, 20);
        for (const MeshTree& tree : trees_of_host_builders(mesh, name)) {
            INFO(tree.name);
            CHECK(count_others(tree, rays) == 0);
        }
    }
    for (const MeshTree& tree : odd_trees()) {
        if (tree.bvh.nodes.empty()) continue;
        INFO(tree.name);
        CHECK(count_others(tree, difficult_rays(tree.mesh, 10)) == 0);
    }
}

TEST_CASE(
    "traversals of pair, skip and compressed layouts leave out what is behind, and end where the caller says so") {
    const Mesh mesh = generate_scene("soup", 5000);
    const Bvh bvh = build(mesh, "binned-sah");
    const std::vector<Ray> rays = difficult_rays(mesh, 30);
    const auto check = [&](const auto& layout) {
        const Visits visits = count_visits(layout, mesh, rays);
        CHECK(visits.until_any > 0);
        CHECK(visits.until_any * 2 < visits.until_closest);
        CHECK(visits.until_closest * 5 < visits.all * 4);
    };
    check(make_layout<PairLayout>(bvh));
    check(make_layout<SkipLayout>(bvh));
    check(make_layout<Compressed8>(bvh, mesh));
}

TEST_CASE("traversals of pair, skip and compressed layouts take any depth, and visit nothing of none") {
    const Mesh mesh = generate_scene("soup", 20000);
    const MeshTree chain{"chain", mesh, chain_tree(mesh)};
    CHECK(make_layout<Compressed8>(chain.bvh, mesh).depth > 1000);
    CHECK(count_others(chain, difficult_rays(mesh, 2)) == 0);

    const auto fail = [](const std::vector<std::uint32_t>&, float&) {
        FAIL("visited");
        return true;
    };
    const Ray ray{{0, 0, 0}, 0.0f, {1, 0, 0}};
    traverse_primitives(PairLayout{}, ray, fail);
    traverse_primitives(SkipLayout{}, ray, fail);
    traverse_primitives(Compressed8{}, ray, fail);
    const auto pair = make_layout<PairLayout>(chain.bvh);
    const auto skip = make_layout<SkipLayout>(chain.bvh);
    const auto compressed8 = make_layout<Compressed8>(chain.bvh, mesh);
    for (const Ray& untraceable : untraceable_rays()) {
        traverse_primitives(pair, untraceable, fail);
        traverse_primitives(skip, untraceable, fail);
        traverse_primitives(compressed8, untraceable, fail);
    }
}
