// What is special about H-PLOC: both shapes build the definition's tree, whatever the options, however uneven the
// Morton tree, and wherever the lane shape cuts it into pieces.
#include <algorithm>
#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/tree_statistics.hpp"
#include "device/build/cluster_bench.hpp"
#include "device/build/stage_bench.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/compare_trees.hpp"
#include "support/meshes.hpp"
#include "support/oracle/hploc_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Codes = std::vector<std::uint64_t>;

BuildOptions fast_options() {
    BuildOptions options;
    options.device.code_bits = 33;
    options.hploc.small_range = 256;
    return options;
}

BuildOptions window_options(std::uint32_t radius) {
    BuildOptions options;
    options.hploc.search_radius = radius;
    return options;
}

/// Each value of each option at least once. Few, since each is a program of its own in each shape.
std::vector<BuildOptions> all_options() {
    BuildOptions narrow = window_options(1);
    narrow.hploc.cluster_limit = 8;
    narrow.hploc.small_range = 2;
    narrow.hploc.small_limit = 1;
    narrow.hploc.merge_pairs = false;
    BuildOptions uneven;  // nodes of 13 to 16 primitives may have fewer clusters, and none is reduced
    uneven.hploc.small_range = 12;
    uneven.hploc.small_limit = 3;
    uneven.hploc.merge_pairs = false;
    return {BuildOptions{}, fast_options(), window_options(8), narrow, uneven};
}

BuildOptions leaf_options(std::uint32_t leaf_size) {
    BuildOptions options;
    options.hploc.leaf_size = leaf_size;
    return options;
}

/// Checks both shapes on keys that may be equal. False after the first that fails, so that a loop can stop.
bool expect_hploc_tree(BuildOptions options, const MortonOrder& order, const std::string& name) {
    options.device.code_bits = 63;
    const OracleTree expected = hploc_tree(order, options.hploc);
    // Packed keys are all different: equal codes come from no build but one with all 63 bits.
    if (std::ranges::adjacent_find(order.codes) != order.codes.end()) options.device.code_bits = 63;
    for (const Shape shape : kBothShapes) {
        options.device.shape = shape;
        INFO(to_string(shape) << ", " << order.bounds.size() << " primitives: " << name);
        if (!expect_cluster_tree(run_cluster(algorithm_of("hploc"), options, order), expected)) return false;
    }
    return true;
}

/// `codes`, which are sorted, over boxes that have nothing to do with them.
MortonOrder order_of_codes(const Codes& codes) {
    REQUIRE(std::ranges::is_sorted(codes));
    MortonOrder order = order_of_boxes(random_boxes(codes.size()));
    order.codes = codes;
    return order;
}

/// Each leaf but the first parts from all before it.
Codes chain() {
    Codes codes{0};
    for (std::uint32_t bit = 0; bit < 63; ++bit)
        codes.push_back(std::uint64_t{1} << bit);
    return codes;
}

}  // namespace

TEST_CASE("hploc: random triangles at sizes around the limits of a node and of a piece") {
    const BuildOptions options;
    for (const std::size_t size : {1u,  2u,  3u,  4u,  5u,  7u,  8u,   9u,    15u,   16u,   17u,   18u,   31u,
                                   32u, 33u, 34u, 63u, 64u, 65u, 100u, 1000u, 1023u, 1024u, 1025u, 2049u, 20000u}) {
        if (!expect_hploc_tree(options, random_order(size), "random")) return;
    }
}

TEST_CASE("hploc: every option") {
    const std::vector<BuildOptions> options = all_options();
    for (std::size_t k = 0; k < options.size(); ++k) {
        for (const std::size_t size : {1u, 2u, 3u, 12u, 13u, 17u, 33u, 65u, 1000u, 5000u}) {
            if (!expect_hploc_tree(options[k], random_order(size), "options " + std::to_string(k))) return;
        }
    }
}

TEST_CASE("hploc: boxes that are hard on builders") {
    for (const BoxSet& set : hard_box_sets(2000)) {
        const MortonOrder order = morton_order(mesh_of_boxes(set.boxes), MortonCode::xyz);
        expect_hploc_tree({}, order, set.name);
        expect_hploc_tree(fast_options(), order, set.name + ", fast");
        expect_hploc_tree(window_options(8), order, set.name + ", window");
    }
}

TEST_CASE("hploc: uneven Morton trees") {
    Codes between_equal_ones(3000, 0);
    const Codes deep = chain();
    between_equal_ones.insert(between_equal_ones.end(), deep.begin(), deep.end());
    between_equal_ones.insert(between_equal_ones.end(), 3000, deep.back());
    Codes mirrored;
    for (const std::uint64_t code : deep)
        mirrored.push_back((std::uint64_t{1} << 63) - 1 - code);
    std::ranges::reverse(mirrored);
    Codes runs;
    for (std::uint32_t i = 0; i < 5000; ++i)
        runs.push_back(i / 37);
    for (const BuildOptions& options : {BuildOptions{}, fast_options()}) {
        expect_hploc_tree(options, order_of_codes(deep), "a chain");
        expect_hploc_tree(options, order_of_codes(mirrored), "a chain to the right");
        expect_hploc_tree(options, order_of_codes(between_equal_ones), "a chain between equal codes");
        expect_hploc_tree(options, order_of_codes(runs), "runs of equal codes");
        expect_hploc_tree(options, order_of_codes(Codes(4097, 42)), "equal codes");
    }
}

TEST_CASE("hploc: leaves of several primitives, at any size") {
    for (const std::uint32_t leaf_size : {2u, 3u, 4u, 8u}) {
        INFO("leaves of " << leaf_size);
        for (std::size_t size = 1; size <= 50; ++size) {
            if (!expect_hploc_tree(leaf_options(leaf_size), random_order(size), "random")) return;
        }
        for (const std::size_t size : {63u, 64u, 65u, 127u, 128u, 129u, 500u, 1000u, 1024u, 4096u, 20000u}) {
            if (!expect_hploc_tree(leaf_options(leaf_size), random_order(size), "random")) return;
        }
    }
}

TEST_CASE("hploc: leaves of several primitives of hard boxes and uneven Morton trees") {
    const Codes deep = chain();
    Codes mirrored;
    for (const std::uint64_t code : deep)
        mirrored.push_back((std::uint64_t{1} << 63) - 1 - code);
    std::ranges::reverse(mirrored);
    Codes runs;
    for (std::uint32_t i = 0; i < 3000; ++i)
        runs.push_back(i / 37);
    Codes long_chain;  // of codes in runs, which end everywhere within a word of 64
    for (const std::uint64_t code : deep)
        long_chain.insert(long_chain.end(), 1 + code % 11, code);
    for (const std::uint32_t leaf_size : {2u, 4u, 8u}) {
        INFO("leaves of " << leaf_size);
        const BuildOptions options = leaf_options(leaf_size);
        expect_hploc_tree(options, order_of_codes(deep), "a chain");
        expect_hploc_tree(options, order_of_codes(mirrored), "a chain to the right");
        expect_hploc_tree(options, order_of_codes(long_chain), "a chain of equal codes");
        expect_hploc_tree(options, order_of_codes(runs), "runs of equal codes");
        expect_hploc_tree(options, order_of_codes(Codes(4097, 42)), "equal codes");
        for (const BoxSet& set : hard_box_sets(1000))
            expect_hploc_tree(options, morton_order(mesh_of_boxes(set.boxes), MortonCode::xyz), set.name);
    }
}

TEST_CASE("hploc: leaves of several primitives with every other option") {
    std::vector<BuildOptions> options = all_options();
    for (std::size_t k = 0; k < options.size(); ++k) {
        options[k].hploc.leaf_size = 3;
        for (const std::size_t size : {3u, 5u, 40u, 100u, 3000u})
            expect_hploc_tree(options[k], random_order(size), "options " + std::to_string(k));
    }
}

TEST_CASE("hploc: leaves of several primitives, in as many pieces as a large device takes") {
    BuildOptions options = leaf_options(4);
    options.device.code_bits = 63;
    const MortonOrder order = random_order(150000);
    const OracleTree expected = hploc_tree(order, options.hploc);
    for (const Shape shape : kBothShapes) {
        INFO(to_string(shape));
        options.device.shape = shape;
        expect_cluster_tree(run_cluster(algorithm_of("hploc"), large_device_settings(options), order), expected);
    }
}

TEST_CASE("hploc: leaves of several primitives over every generated scene, some primitives inactive") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        Mesh mesh = generate_scene(scene.name, 2000);
        deactivate_triangles(mesh, 2, 7);
        for (const std::uint32_t leaf_size : {2u, 4u, 8u}) {
            for (const Shape shape : kBothShapes) {
                BuildOptions options = options_of(shape);
                options.hploc.leaf_size = leaf_size;
                Builder builder = make_builder("hploc", options);
                const Bvh tree = builder.build(mesh);
                expect_oracle_tree(builder, tree, mesh, std::string(scene.name));
                CHECK(tree_statistics(tree).leaves_by_size.size() <= leaf_size + 1);
            }
        }
    }
}

TEST_CASE("hploc: as many pieces as a large device takes") {
    const MortonOrder order = random_order(150000);
    const OracleTree expected = hploc_tree(order);
    for (const Shape shape : kBothShapes) {
        INFO(to_string(shape));
        expect_cluster_tree(run_cluster(algorithm_of("hploc"), large_device_settings(options_of(shape)), order),
                            expected);
    }
}

TEST_CASE("hploc: inactive primitives, duplicates and both sorts") {
    Mesh mesh = random_triangles(3000);
    const Mesh equal = coincident_triangles(500);
    for (const Triangle& t : equal.triangles) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {equal.vertices[t[0]], equal.vertices[t[1]], equal.vertices[t[2]]});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    deactivate_triangles(mesh, 2, 7);
    for (const Shape shape : kBothShapes) {
        for (const Shape sort_shape : kBothShapes) {
            BuildOptions options = options_of(shape);
            options.device.sort_shape = sort_shape;
            Builder builder = make_builder("hploc", options);
            expect_oracle_tree(builder, builder.build(mesh), mesh, "sort " + std::string(to_string(sort_shape)));
        }
    }
}

TEST_CASE("hploc oracle: trees are valid for all options") {
    for (const std::size_t count : {1u, 2u, 3u, 16u, 17u, 33u, 300u}) {
        const Mesh mesh = random_triangles(count);
        const MortonOrder order = morton_order(mesh, MortonCode::xyz);
        for (const BuildOptions& options : all_options())
            CHECK(validate(hploc_tree(order, options.hploc).bvh, mesh).error == "");
    }
}

TEST_CASE("hploc oracle: what one node holds is clustered as PLOC does it") {
    HplocConfig as_published;
    as_published.merge_pairs = false;
    as_published.search_radius = 16;
    for (std::size_t count = 1; count <= 17; ++count) {
        for (const std::uint32_t seed : {1u, 2u, 3u}) {
            const MortonOrder order = morton_order(random_triangles(count, seed), MortonCode::xyz);
            CHECK(compare_trees(hploc_tree(order, as_published).bvh,
                                ploc_tree(order, as_published.search_radius, Comparison::packed).bvh) == "");
        }
    }
}

TEST_CASE("hploc oracle: equal boxes give a shallow tree") {
    const Mesh mesh = coincident_triangles(1 << 14);
    const MortonOrder order = morton_order(mesh, MortonCode::xyz);
    for (const BuildOptions& options : all_options())
        CHECK(validate(hploc_tree(order, options.hploc).bvh, mesh).depth <= 28);
}
