// Hits are the same bits on every processor and with every instruction set.
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/instruction_sets.hpp"
#include "support/views.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// FNV-1a over the closest hits of rays to some of the mesh's vertices.
std::uint64_t hash_of_hits(const Mesh& mesh, TriangleTest test) {
    const Bvh tree = Builder("sweep-sah").build(mesh);
    const Tracer tracer(tree, mesh, {test});
    std::uint64_t hash = 0xcbf29ce484222325u;
    const auto mix = [&](std::uint32_t word) { hash = (hash ^ word) * 0x100000001b3u; };
    for (const Ray& ray : rays_to_vertices(tree.nodes[0].bounds(), mesh)) {
        const Hit hit = tracer.closest(ray);
        mix(hit.primitive);
        mix(std::bit_cast<std::uint32_t>(hit.t));
        mix(std::bit_cast<std::uint32_t>(hit.u));
        mix(std::bit_cast<std::uint32_t>(hit.v));
    }
    return hash;
}

struct HitHash {
    const char* scene;
    TriangleTest test;
    std::uint64_t hash;
};

constexpr HitHash kHitHashes[] = {
    {"soup", TriangleTest::watertight, 0xde1e5ee5c0ae8ad9u},
    {"soup", TriangleTest::moller_trumbore, 0xdeb71105dc02078bu},
    {"city", TriangleTest::watertight, 0x403d918545e9e470u},
    {"city", TriangleTest::moller_trumbore, 0x26ae0988f5b3ba3du},
    {"hair", TriangleTest::watertight, 0x7a855144a4717a93u},
    {"hair", TriangleTest::moller_trumbore, 0x470f6a57878aaa66u},
};

}  // namespace

TEST_CASE("hits are the bits that they were", "[hit_hashes]") {
    for (const HitHash& row : kHitHashes) {
        const Mesh mesh = generate_scene(row.scene, 5000);
        with_each_instruction_set([&] {
            INFO(row.scene << ", test " << static_cast<int>(row.test));
            CHECK(hash_of_hits(mesh, row.test) == row.hash);
        });
    }
}
