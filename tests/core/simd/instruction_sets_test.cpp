// Host builders and the tracer give the same bits with every instruction set of this processor.
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/host/median.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/trace/binary_tracer.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/builders.hpp"
#include "support/environment_variable.hpp"
#include "support/expect_error.hpp"
#include "support/instruction_sets.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Bytes = std::vector<std::byte>;

template <typename Element>
void append(Bytes& bytes, const std::vector<Element>& elements) {
    const auto added = std::as_bytes(std::span(elements));
    bytes.insert(bytes.end(), added.begin(), added.end());
}

Bytes tree_bytes(std::string_view id, const Mesh& mesh) {
    BuildOptions options;
    options.max_leaf_size = 8;
    const Bvh bvh = build(mesh, id, options);
    Bytes bytes;
    append(bytes, bvh.nodes);
    append(bytes, bvh.primitive_ids);
    return bytes;
}

Bytes hit_bytes(const Mesh& mesh, const Bvh& bvh, const std::vector<Ray>& rays) {
    Bytes bytes;
    for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
        const Tracer tracer(bvh, mesh, {test});
        const BinaryTracer binary(bvh, mesh, {test});
        std::vector<Hit> hits;
        std::vector<RayCounts> costs;
        std::vector<std::uint8_t> any;
        for (const Ray& ray : rays) {
            RayCounts counts;
            hits.push_back(tracer.closest(ray));
            hits.push_back(binary.closest(ray, counts));
            any.push_back(tracer.any(ray) ? 1 : 0);
            costs.push_back(counts);
            costs.push_back(binary.visits(ray));
        }
        append(bytes, hits);
        append(bytes, costs);
        append(bytes, any);
    }
    return bytes;
}

/// Checks that `make` makes the same bytes with every instruction set.
template <typename Make>
void expect_same_bytes(const Make& make) {
    std::optional<Bytes> expected;
    with_each_instruction_set([&] {
        const Bytes bytes = make();
        if (!expected) expected = bytes;
        const bool same = bytes == *expected;
        CHECK(same);
    });
}

}  // namespace

TEST_CASE("host builders give the same bytes with every instruction set", "[simd]") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        for (const std::uint32_t size : {1u, 7u, 3000u}) {
            const Mesh mesh = generate_scene(scene.name, size);
            for (const std::string_view id : host_builders()) {
                INFO(id << " on " << scene.name << ":" << size);
                expect_same_bytes([&] { return tree_bytes(id, mesh); });
            }
        }
    }
}

TEST_CASE("the tracer finds the same bits with every instruction set", "[simd]") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        INFO(scene.name);
        const Mesh mesh = generate_scene(scene.name, 2000);
        const Bvh bvh = build(mesh, "median");
        const std::vector<Ray> rays = difficult_rays(mesh, 200);
        expect_same_bytes([&] { return hit_bytes(mesh, bvh, rays); });
    }
}

TEST_CASE("CLBVH_SIMD names an instruction set, or is an error", "[simd]") {
    const std::vector<Aabb> boxes{{{0, 0, 0}, {1, 1, 1}}};
    for (const simd::InstructionSet set : simd::kInstructionSets) {
        const std::string name(simd::to_string(set));
        const EnvironmentVariable environment("CLBVH_SIMD", name.c_str());
        if (simd::is_available(set)) {
            CHECK(build_median(boxes).primitive_ids.size() == 1);
        } else {
            expect_error(ErrorCode::unsupported, {"CLBVH_SIMD is " + name, "scalar"},
                         [&] { (void)build_median(boxes); });
        }
    }
    const EnvironmentVariable environment("CLBVH_SIMD", "avx");
    expect_error(ErrorCode::invalid_input, {"CLBVH_SIMD is avx", "scalar"}, [&] { (void)build_median(boxes); });
    expect_error(ErrorCode::invalid_input, {"CLBVH_SIMD is avx"}, [] { const Tracer tracer(Bvh{}, Mesh{}); });
}

TEST_CASE("the instruction set that is selected is the one in use", "[simd]") {
    with_each_instruction_set([] {
        const simd::InstructionSet selected = simd::instruction_set();
        CHECK(simd::is_available(selected));
    });
    CHECK(simd::is_available(simd::InstructionSet::scalar));
    CHECK_FALSE((simd::is_available(simd::InstructionSet::sse2) && simd::is_available(simd::InstructionSet::neon)));
}
