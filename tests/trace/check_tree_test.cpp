// Trees that cannot be traced are refused, and trees of any shape can.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/binary_tracer.hpp"
#include "clbvh/trace/tracer.hpp"
#include "core/random.hpp"
#include "core/tree_walk.hpp"
#include "support/expect_error.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// A valid tree with one thing changed by `spoil`.
template <typename Spoil>
void expect_refusal(std::initializer_list<std::string> parts, Spoil spoil) {
    Mesh mesh = generate_scene("soup", 50);
    Bvh bvh = build(mesh, "median");
    spoil(bvh, mesh);
    expect_error(ErrorCode::invalid_input, parts, [&] { const Tracer tracer(bvh, mesh); });
}

std::size_t first_leaf(const Bvh& bvh) {
    std::size_t node = 0;
    while (!bvh.nodes[node].is_leaf())
        node = bvh.nodes[node].first;
    return node;
}

/// A tree without forks: each inner node has a leaf of one triangle and the rest of the tree, the rest first where
/// `rest_is_first`. The triangles stand behind each other along x.
struct Chain {
    Mesh mesh;
    Bvh bvh;

    Chain(std::uint32_t length, bool rest_is_first) {
        for (std::uint32_t i = 0; i < length; ++i) {
            const auto x = static_cast<float>(i), size = 1.0f + 0.5f * static_cast<float>(i % 3);
            mesh.vertices.insert(mesh.vertices.end(), {{x, -size, -size}, {x, size, -size}, {x, 0.0f, size}});
            mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
            bvh.primitive_ids.push_back(i);
        }
        bvh.primitive_count = length;
        bvh.nodes.resize(2 * std::size_t{length});
        std::size_t rest = 0;
        for (std::uint32_t i = 0; i + 1 < length; ++i) {
            bvh.nodes[rest] = node_over(i, length, 2 * (i + 1), 0);
            const std::size_t leaf = 2 * (std::size_t{i} + 1) + (rest_is_first ? 1 : 0);
            bvh.nodes[leaf] = node_over(i, i + 1, i, 1);
            rest = leaf ^ 1;
        }
        bvh.nodes[rest] = node_over(length - 1, length, length - 1, 1);
    }

    static Node node_over(std::uint32_t begin, std::uint32_t end, std::uint32_t first, std::uint32_t count) {
        return {{static_cast<float>(begin), -2, -2}, first, {static_cast<float>(end - 1), 2, 2}, count};
    }
};

/// What is wrong with the nodes, by a walk in order; empty where nothing is.
std::string fault_in_order(const Bvh& bvh) {
    TreeWalk walk(bvh);
    std::uint64_t references = 0;
    while (walk.next()) {
        references += bvh.nodes[walk.node()].count;
        if (references > bvh.primitive_ids.size())
            return "leaves share primitive ids, the last at " + name_node(walk.node());
    }
    return walk.fault();
}

/// Changes one node.
void put_fault_in(Bvh& bvh, Random& random) {
    const auto any_node = [&] { return random.below(static_cast<std::uint32_t>(bvh.nodes.size())); };
    Node& node = bvh.nodes[any_node()];
    if (node.is_leaf()) {
        (random.below(2) == 0 ? node.first : node.count) += random.below(3) == 0 ? 1u << 31u : 1;
    } else if (random.below(4) == 0) {
        node.first = any_node();
    } else {
        node.first = any_node() & ~1u;
    }
}

}  // namespace

TEST_CASE("trees that are none are refused") {
    expect_refusal({"49 primitives"}, [](Bvh& bvh, Mesh&) { bvh.primitive_count = 49; });
    expect_refusal({"49 triangles"}, [](Bvh&, Mesh& mesh) { mesh.triangles.pop_back(); });
    expect_refusal({"primitive 50 is out of range"}, [](Bvh& bvh, Mesh&) { bvh.primitive_ids[7] = 50; });
    expect_refusal({"triangle 3", "vertex 4000000000"}, [](Bvh&, Mesh& mesh) { mesh.triangles[3][1] = 4000000000u; });
    expect_refusal({"node 0", "odd"}, [](Bvh& bvh, Mesh&) { bvh.nodes[0].first += 1; });
    expect_refusal({"node 0", "4000000000"}, [](Bvh& bvh, Mesh&) { bvh.nodes[0].first = 4000000000u; });
    expect_refusal({"node 0", "root"}, [](Bvh& bvh, Mesh&) { bvh.nodes[0].first = 0; });
    expect_refusal({"another parent"}, [](Bvh& bvh, Mesh&) {
        const Node& root = bvh.nodes[0];
        bvh.nodes[root.first + 1].first = bvh.nodes[root.first].first;
    });
    expect_refusal({"ends at"}, [](Bvh& bvh, Mesh&) { bvh.nodes[first_leaf(bvh)].first = 4294967295u; });
    expect_refusal({"share"}, [](Bvh& bvh, Mesh&) {
        Node& leaf = bvh.nodes[first_leaf(bvh)];
        leaf.first = 0;
        leaf.count = 50;
    });
    expect_refusal({"there are 1 nodes"}, [](Bvh& bvh, Mesh&) { bvh.nodes.resize(1); });
}

TEST_CASE("the first of some faults in a large tree is named") {
    const Mesh mesh = generate_scene("city", 40'000);
    const Bvh valid = build(mesh, "median");
    Random random(11);
    std::size_t refused = 0;
    for (int round = 0; round < 100; ++round) {
        Bvh bvh = valid;
        for (std::uint32_t faults = 1 + random.below(3); faults > 0; --faults)
            put_fault_in(bvh, random);
        const std::string fault = fault_in_order(bvh);
        if (fault.empty()) {
            CHECK_NOTHROW(BinaryTracer(bvh, mesh));
        } else {
            ++refused;
            expect_error(ErrorCode::invalid_input, {"cannot be traced: " + fault + ";"},
                         [&] { const BinaryTracer tracer(bvh, mesh); });
        }
    }
    CHECK(refused > 50);
}

TEST_CASE("a node with two parents is found where all is no more than the tree") {
    const Mesh mesh = generate_scene("city", 40'000);
    BuildOptions options;
    options.max_leaf_size = 1;
    Bvh bvh = build(mesh, "median", options);
    // One of the inner nodes with two leaves gets those of another, whose ids are as many.
    const auto has_two_leaves = [&](const Node& node) {
        return !node.is_leaf() && bvh.nodes[node.first].is_leaf() && bvh.nodes[node.first + 1].is_leaf();
    };
    std::vector<std::size_t> found;
    for (std::size_t i = 2; i < bvh.nodes.size(); ++i)
        if (has_two_leaves(bvh.nodes[i])) found.push_back(i);
    REQUIRE(found.size() > 1000);
    bvh.nodes[found.back()].first = bvh.nodes[found.front()].first;
    expect_error(ErrorCode::invalid_input, {"have another parent"}, [&] { const BinaryTracer tracer(bvh, mesh); });
}

TEST_CASE("the first of several primitives out of range is named") {
    Mesh mesh = generate_scene("city", 40'000);
    Bvh bvh = build(mesh, "median");
    bvh.primitive_ids[39'000] = 40'000;
    mesh.triangles[bvh.primitive_ids[38'000]][2] = 1u << 31u;
    const std::string triangle = "triangle " + std::to_string(bvh.primitive_ids[38'000]) + " has vertex";
    expect_error(ErrorCode::invalid_input, {triangle}, [&] { const Tracer tracer(bvh, mesh); });
    bvh.primitive_ids[37'000] = 50'000;
    expect_error(ErrorCode::invalid_input, {"primitive 50000"}, [&] { const Tracer tracer(bvh, mesh); });
}

TEST_CASE("a vertex out of range in a triangle that is not in the tree does no harm") {
    Mesh mesh = generate_scene("city", 1000);
    mesh.vertices.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
    mesh.triangles.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
    const Bvh bvh = build(mesh, "median");
    mesh.triangles.back()[2] = 1u << 31u;
    CHECK_NOTHROW(Tracer(bvh, mesh));
}

TEST_CASE("a tree may be a single leaf, without the unused node beside it") {
    const Mesh mesh = generate_scene("soup", 9);
    Bvh bvh;
    bvh.primitive_count = 9;
    Aabb box;
    for (std::uint32_t i = 0; i < 9; ++i) {
        bvh.primitive_ids.push_back(8 - i);
        box = merge(box, triangle_bounds(mesh, i));
    }
    bvh.nodes = {{{box.lower.x, box.lower.y, box.lower.z}, 0, {box.upper.x, box.upper.y, box.upper.z}, 9}};
    const Tracer tracer(bvh, mesh);
    CHECK(BinaryTracer(bvh, mesh).depth() == 0);
    std::size_t differences = 0;
    for (const Ray& ray : difficult_rays(mesh, 200))
        differences += same_bits(tracer.closest(ray), brute_force_closest(mesh, ray)) ? 0 : 1;
    CHECK(differences == 0);
}

TEST_CASE("trees of any depth are traced") {
    for (const std::uint32_t length : {2u, 60u, 64u, 65u, 66u, 67u, 500u, 600u, 100000u}) {
        for (const bool rest_is_first : {false, true}) {
            INFO(length << ' ' << rest_is_first);
            const Chain chain(length, rest_is_first);
            const Tracer tracer(chain.bvh, chain.mesh);
            const BinaryTracer binary(chain.bvh, chain.mesh);
            CHECK(binary.depth() == length - 1);
            const auto end = static_cast<float>(length);
            // From the far end every leaf is deferred, and from the near end none.
            const Ray from_end{{end, 0.0f, -0.5f}, 0.0f, {-1, 0, 0}};
            const Ray from_begin{{-1.0f, 0.0f, -0.5f}, 0.0f, {1, 0, 0}};
            RayCounts counts;
            CHECK(tracer.closest(from_end).primitive == length - 1);
            CHECK(binary.closest(from_end, counts).primitive == length - 1);
            CHECK(counts.inner_nodes == length - 1);
            CHECK(tracer.closest(from_begin).primitive == 0);
            CHECK(tracer.any(from_end));
            std::vector<Hit> hits_of_many(35);
            std::vector<std::uint8_t> is_hit(hits_of_many.size());
            const std::vector<Ray> many(hits_of_many.size(), from_end);
            tracer.closest(many, hits_of_many);
            tracer.any(many, is_hit);
            CHECK(std::ranges::all_of(hits_of_many, [&](const Hit& hit) { return hit.primitive == length - 1; }));
            CHECK(std::ranges::count(is_hit, 1) == 35);
            CHECK(binary.visits(from_end) == RayCounts{length - 1, length, length});
            std::size_t hits = 0;
            tracer.all(from_end, [&](const Hit&) { return ++hits > 0; });
            CHECK(hits == length);
        }
    }
}
