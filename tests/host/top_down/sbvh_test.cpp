// SBVH: no part of a triangle is lost, memory is bounded, and without spare references it is binned SAH to the bit.
#include "clbvh/host/sbvh.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "clbvh/core/validate.hpp"
#include "clbvh/host/binned_sah.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "host/top_down/sbvh.hpp"
#include "host/top_down/sbvh_move.hpp"
#include "support/box_sets.hpp"
#include "support/builders.hpp"
#include "support/compare_trees.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"
#include "support/references.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using LeafLists = std::vector<std::vector<Aabb>>;

/// For each primitive the boxes of the leaves that name it.
LeafLists leaves_of_primitives(const Bvh& bvh) {
    LeafLists lists(bvh.primitive_count);
    std::vector<std::uint32_t> open;
    if (!bvh.empty()) open.push_back(0);
    while (!open.empty()) {
        const Node& node = bvh.nodes[open.back()];
        open.pop_back();
        if (!node.is_leaf()) {
            open.push_back(node.first);
            open.push_back(node.first + 1);
            continue;
        }
        for (std::uint32_t i = 0; i < node.count; ++i)
            lists[bvh.primitive_ids[node.first + i]].push_back(node.bounds());
    }
    return lists;
}

using Point = std::array<double, 3>;

bool contains(const Aabb& box, const Point& p, double slack) {
    return double{box.lower.x} - slack <= p[0] && p[0] <= double{box.upper.x} + slack &&
           double{box.lower.y} - slack <= p[1] && p[1] <= double{box.upper.y} + slack &&
           double{box.lower.z} - slack <= p[2] && p[2] <= double{box.upper.z} + slack;
}

/// Points sampled on the triangles that are in none of their leaves.
std::size_t count_lost_points(const Bvh& bvh, const Mesh& mesh, int samples) {
    const LeafLists lists = leaves_of_primitives(bvh);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::size_t lost = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& [a, b, c] = mesh.triangles[i];
        const Vec3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
        for (int sample = 0; sample < samples; ++sample) {
            double u = unit(random);
            double v = unit(random);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const auto mix = [&](float x, float y, float z) { return x * (1 - u - v) + y * u + z * v; };
            const Point point{mix(p.x, q.x, r.x), mix(p.y, q.y, r.y), mix(p.z, q.z, r.z)};
            const double largest = std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
            const auto covers = [&](const Aabb& box) { return contains(box, point, largest * 0x1p-48); };
            if (std::ranges::none_of(lists[i], covers)) ++lost;
        }
    }
    return lost;
}

/// Same nodes in the same places; -0 equals +0.
bool same_tree(const Bvh& a, const Bvh& b) {
    return a.nodes == b.nodes && a.primitive_ids == b.primitive_ids;
}

void expect_sound(const Mesh& mesh, const SbvhConfig& config, const std::string& where) {
    INFO(where);
    const Bvh bvh = build_sbvh(mesh, config);
    CHECK(validate(bvh, mesh).error == "");
    CHECK(validate(bvh, mesh).depth <= 288);
    CHECK(static_cast<double>(bvh.primitive_ids.size()) <=
          double{config.reference_budget} * static_cast<double>(mesh.triangles.size()));
}

}  // namespace

TEST_CASE("every point sampled on a triangle lies in a leaf that references it, on every generated scene") {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        for (const std::uint32_t count : {1u, 2u, 3u, 10u, 100u, 5000u}) {
            INFO(scene.name << ", " << count << " triangles");
            const Mesh mesh = generate_scene(scene.name, count);
            const Bvh bvh = build_sbvh(mesh);
            CHECK(bvh.split_references == (count > 0));
            CHECK(count_lost_points(bvh, mesh, 40) == 0);
            CHECK(validate(bvh, mesh).error == "");
        }
    }
}

TEST_CASE("sbvh is valid at every small size") {
    CHECK(build_sbvh({}).empty());
    for (std::uint32_t count = 1; count <= 1000; count += 1 + count / 12) {
        expect_sound(generate_scene("hair", count), {}, "hair " + std::to_string(count));
        expect_sound(generate_scene("city", count), {}, "city " + std::to_string(count));
    }
}

TEST_CASE("sbvh is valid with other options, and never exceeds its budget") {
    const Mesh mesh = generate_scene("hair", 3000);
    for (const float budget : {1.0f, 1.0001f, 1.1f, 1.5f, 3.0f, 8.0f}) {
        SbvhConfig config;
        config.reference_budget = budget;
        expect_sound(mesh, config, "budget " + std::to_string(budget));
    }
    for (const std::uint32_t bins : {2u, 3u, 17u, 64u}) {
        SbvhConfig config;
        config.bin_count = bins;
        config.spatial_bin_count = bins;
        config.max_leaf_size = 1 + bins / 2;
        expect_sound(mesh, config, "bins " + std::to_string(bins));
    }
    SbvhConfig eager;
    eager.alpha = 0.0f;
    eager.inner_cost = 0.1f;
    eager.max_leaf_size = 1;
    expect_sound(mesh, eager, "eager");
}

TEST_CASE("sbvh is valid on inputs that are hard on builders") {
    for (const BoxSet& set : hard_box_sets(3000)) {
        const Mesh mesh = mesh_of_boxes(set.boxes);
        expect_sound(mesh, {}, set.name);
        CHECK(count_lost_points(build_sbvh(mesh), mesh, 10) == 0);
    }
    expect_sound(coincident_triangles(100000), {}, "coincident");
    Mesh mesh = random_triangles(500);
    deactivate_triangles(mesh, 3, 7);
    expect_sound(mesh, {}, "some inactive");
}

TEST_CASE("triangles that all cross one point are told apart by spatial splits") {
    // Equal centroids: no object split finds a border.
    Mesh mesh;
    for (std::uint32_t i = 0; i < 64; ++i) {
        const float angle = static_cast<float>(i) * 0.0490873852f;
        const float x = std::cos(angle);
        const float y = std::sin(angle);
        mesh.vertices.insert(mesh.vertices.end(), {{-x, -y, 0}, {x, y, 0}, {0, 0, 0.001f}});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    SbvhConfig config;
    config.reference_budget = 8.0f;
    expect_sound(mesh, config, "star");
    config.reference_budget = 1.0f;
    const double whole = sah_cost(build_sbvh(mesh, config));
    config.reference_budget = 8.0f;
    CHECK(sah_cost(build_sbvh(mesh, config)) < 0.7 * whole);
}

TEST_CASE("sbvh without spare references is binned SAH") {
    SbvhConfig config;
    config.reference_budget = 1.0f;
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        // The large ones are divided in parallel.
        for (const std::uint32_t count : {1u, 9u, 1000u, 20000u}) {
            INFO(scene.name << ", " << count << " triangles");
            const Mesh mesh = generate_scene(scene.name, count);
            const Bvh bvh = build_sbvh(mesh, config);
            CHECK_FALSE(bvh.split_references);
            CHECK(same_tree(bvh, build_binned_sah(boxes_of(mesh))));
            CHECK(validate(bvh, mesh).error == "");
        }
    }
}

TEST_CASE("sbvh gives the same bytes on any number of threads") {
    for (const char* scene : {"hair", "city"}) {
        const Mesh mesh = generate_scene(scene, 40000);
        const Bvh expected = build_sbvh(mesh);
        for (const int threads : {1, 2}) {
            INFO(scene << ", " << threads << " threads");
            tbb::task_arena arena(threads);
            CHECK(same_bytes(arena.execute([&] { return build_sbvh(mesh); }), expected));
        }
    }
}

TEST_CASE("spatial splits make better trees of long diagonal triangles, and of large ones among small") {
    SbvhConfig object_splits;
    object_splits.reference_budget = 1.0f;
    const auto ratio = [&](const char* scene) {
        const Mesh mesh = generate_scene(scene, 10000);
        return sah_cost(build_sbvh(mesh)) / sah_cost(build_sbvh(mesh, object_splits));
    };
    CHECK(ratio("hair") < 0.9);
    CHECK(ratio("city") < 0.95);
}

TEST_CASE("overlap below alpha is not worth a spatial split") {
    const Mesh mesh = generate_scene("hair", 2000);
    SbvhConfig config;
    config.alpha = 1.0f;
    const Bvh bvh = build_sbvh(mesh, config);
    CHECK(bvh.split_references);
    CHECK(same_tree(bvh, build_binned_sah(boxes_of(mesh))));
}

TEST_CASE("planes are tried where children overlap by more than the configured part of their parent") {
    // A row of eight boxes at either end of a beam that is 10 long. Without a plane, the beam shares a child with one
    // row, and that child reaches over the other row.
    for (const float width : {1.0f, 2.0f, 3.0f}) {
        std::vector<Aabb> boxes{{{0, 0, 0}, {10, 1, 1}}};
        for (int i = 0; i < 8; ++i) {
            const float x = width * static_cast<float>(i) / 8;
            boxes.push_back({{x, 0, 0}, {x + width / 8, 1, 1}});
            boxes.push_back({{10 - x - width / 8, 0, 0}, {10 - x, 1, 1}});
        }
        const float part = (2 * width + 1) / 21;
        SbvhConfig config;
        config.max_leaf_size = 9;
        config.inner_cost = 1000;
        const auto references = [&](float overlap) {
            config.overlap = overlap;
            return build_sbvh(boxes, config).primitive_ids.size();
        };
        INFO("rows of " << width << ", overlap " << part);
        CHECK(references(0) == 18);
        CHECK(references(part - 0.01f) == 18);
        CHECK(references(part + 0.01f) == 17);
    }
}

TEST_CASE("a straddler that hardly costs more whole is not cut") {
    // Hundred boxes to each side of x = 8, and one that reaches over it by a sixteenth.
    std::vector<host::Reference> references;
    for (std::uint32_t i = 0; i < 100; ++i) {
        references.push_back({{0, 0, 0}, i, {7.5f, 1, 1}, 0});
        references.push_back({{8.5f, 0, 0}, 100 + i, {16, 1, 1}, 0});
    }
    references.push_back({{7, 0, 0}, 200, {8.0625f, 1, 1}, 0});
    references.push_back({{0, 0, 0}, 201, {16, 1, 1}, 0});
    const host::SpacedRange range{0, 250, 0, static_cast<std::uint32_t>(references.size())};
    const Box4 box = Box4::of(references.back());
    const host::SpatialBinning binning(box, 2);
    host::SpatialBinSet bins(2);
    bins.add(nullptr, references, binning);
    const host::SpatialSplit split = bins.find_split(binning, 250);
    REQUIRE(split.found());
    CHECK(split.left_count == 102);
    CHECK(split.right_count == 102);
    std::vector<host::Reference> target(250);
    const host::Division division =
        host::move_references(range, references.data(), target.data(), host::SpatialRule(nullptr, binning, split));
    CHECK(division.counts[0] == 102);
    CHECK(division.counts[1] == 101);
    const auto left = std::ranges::find(target, 200u, &host::Reference::primitive);
    REQUIRE(left - target.begin() < 102);
    CHECK(left->upper[0] == 8.0625f);
    CHECK(std::ranges::count(target, 201u, &host::Reference::primitive) == 2);
}

TEST_CASE("sbvh over bare boxes cuts the boxes") {
    for (const BoxSet& set : hard_box_sets(500)) {
        INFO(set.name);
        const Bvh bvh = build_sbvh(set.boxes);
        const LeafLists lists = leaves_of_primitives(bvh);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> unit(0.0, 1.0);
        std::size_t lost = 0;
        for (std::size_t i = 0; i < set.boxes.size(); ++i) {
            const Aabb& box = set.boxes[i];
            for (int sample = 0; sample < 20; ++sample) {
                const auto mix = [&](float a, float b) { return double{a} + unit(random) * (double{b} - double{a}); };
                const Point point{mix(box.lower.x, box.upper.x), mix(box.lower.y, box.upper.y),
                                  mix(box.lower.z, box.upper.z)};
                const double largest = std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
                const auto covers = [&](const Aabb& leaf) { return contains(leaf, point, largest * 0x1p-48); };
                if (std::ranges::none_of(lists[i], covers)) ++lost;
            }
        }
        CHECK(lost == 0);
    }
}

TEST_CASE("sbvh builds the same tree where costs would overflow") {
    const Mesh mesh = generate_scene("hair", 20000);
    const Bvh small = build_sbvh(scaled(mesh, 0x1p-3f));
    const Bvh large = build_sbvh(scaled(mesh, largest_scale(mesh)));
    CHECK(same_topology(large, small));
}

TEST_CASE("sbvh takes less than 400 bytes a reference") {
    const Mesh mesh = generate_scene("hair", 20000);
    for (const float budget : {1.0f, 2.0f, 4.0f}) {
        SbvhConfig config;
        config.reference_budget = budget;
        Scratch scratch;
        Bvh result;
        const host::HostInput input{mesh, mesh.triangles.size(), {}};
        const BuildStats stats = host::run_host_build(
            input, [&](host::HostBuild& build) { host::build_sbvh(build, config); }, {}, scratch, result);
        CHECK(stats.peak_host_bytes > 0);
        CHECK(stats.peak_host_bytes < 400 * result.primitive_ids.size());
    }
}

TEST_CASE("sbvh names what is wrong with its input") {
    const auto expect_rejected = [](const SbvhConfig& config, const std::string& field, const std::string& range) {
        expect_error(ErrorCode::invalid_input, {field, range}, [&] { static_cast<void>(build_sbvh({}, config)); });
    };
    SbvhConfig config;
    config.bin_count = 1;
    expect_rejected(config, "bin_count is 1", "2 to 64");
    config = {};
    config.spatial_bin_count = 65;
    expect_rejected(config, "spatial_bin_count is 65", "2 to 64");
    config = {};
    config.overlap = 1.5f;
    expect_rejected(config, "overlap is 1.5", "0 to 1");
    config.overlap = 0.0f;
    config.alpha = -0.1f;
    expect_rejected(config, "alpha is -0.1", "0 to 1");
    config = {};
    config.reference_budget = 0.5f;
    expect_rejected(config, "reference_budget is 0.5", "1 to 8");
    config = {};
    config.inner_cost = 0.0f;
    expect_rejected(config, "inner_cost is 0", "above 0");
    config = {};
    config.primitive_cost = -1.0f;
    expect_rejected(config, "primitive_cost is -1", "above 0");
    config = {};
    config.max_leaf_size = 65;
    expect_rejected(config, "max_leaf_size is 65", "1 to 64");
    Mesh mesh = random_triangles(10);
    mesh.triangles[4][0] = 1000;
    expect_error(ErrorCode::invalid_input, {"triangle 4"}, [&] { static_cast<void>(build_sbvh(mesh)); });
}
