// The quota of splits goes where the paper's formula says, is kept, and no point of a triangle is lost.
#include "host/split/quota_split.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "clbvh/catalog.hpp"
#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr int kMostLevels = 20;

struct Range {
    double lower;
    double upper;
};

Range range_of(const Aabb& box, int axis) {
    if (axis == 0) return {box.lower.x, box.upper.x};
    if (axis == 1) return {box.lower.y, box.upper.y};
    return {box.lower.z, box.upper.z};
}

Aabb scene_box(const Mesh& mesh) {
    Aabb box;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (!is_inactive(mesh, i)) box = merge(box, triangle_bounds(mesh, i));
    }
    return box;
}

/// Halves the scene until the middle is inside the range: the level of that middle, or kMostLevels.
int level_of(Range scene, const Range& range) {
    for (int level = 0; level < kMostLevels; ++level) {
        const double middle = 0.5 * (scene.lower + scene.upper);
        const auto plane = static_cast<double>(static_cast<float>(middle));
        if (range.lower < plane && plane < range.upper) return level;
        (range.upper <= plane ? scene.upper : scene.lower) = middle;
    }
    return kMostLevels;
}

/// The formula of the paper, written once more.
double expected_priority(const Mesh& mesh, const Aabb& scene, std::size_t triangle) {
    const Aabb box = triangle_bounds(mesh, triangle);
    int level = kMostLevels;
    double length[3]{};
    for (int axis = 0; axis < 3; ++axis) {
        const Range range = range_of(box, axis);
        length[axis] = range.upper - range.lower;
        level = std::min(level, level_of(range_of(scene, axis), range));
    }
    if (level == kMostLevels) return 0.0;
    const auto& [a, b, c] = mesh.triangles[triangle];
    const Vec3 p = mesh.vertices[a], q = mesh.vertices[b], r = mesh.vertices[c];
    // Twice the area of the triangle's shadow on the plane of two coordinates.
    const auto shadow = [&](float Vec3::*u, float Vec3::*v) {
        return std::abs((double{q.*u} - p.*u) * (double{r.*v} - p.*v) - (double{q.*v} - p.*v) * (double{r.*u} - p.*u));
    };
    const double ideal = shadow(&Vec3::x, &Vec3::y) + shadow(&Vec3::y, &Vec3::z) + shadow(&Vec3::z, &Vec3::x);
    const double surface = 2.0 * (length[0] * length[1] + length[1] * length[2] + length[2] * length[0]);
    return std::pow(std::ldexp(std::max(surface - ideal, 0.0), -level), 1.0 / 3.0);
}

const ProgressCallback kNoProgress;

host::SplitPlan plan_of(const Mesh& mesh, float quota) {
    host::HostStages stages(kNoProgress);
    stages.begin("presplit", 0.0, 1.0);
    return {mesh, quota, stages};
}

host::PartBoxes split(const Mesh& mesh, float quota) {
    host::HostStages stages(kNoProgress);
    stages.begin("presplit", 0.0, 1.0);
    host::PartBoxes parts;
    host::split_to_quota(mesh, quota, stages, parts);
    return parts;
}

bool same(const host::PartBoxes& a, const host::PartBoxes& b) {
    return a.boxes == b.boxes && a.source == b.source;
}

BuildOptions quota_options(float quota) {
    BuildOptions options;
    options.split_quota = quota;
    return options;
}

}  // namespace

TEST_CASE("quota_split: priorities are those of the formula") {
    for (const char* const scene : {"hair", "city", "soup", "terrain"}) {
        INFO(scene);
        Mesh mesh = generate_scene(scene, 2000);
        mesh.triangles.push_back({0, 0, 0});
        const Aabb box = scene_box(mesh);
        const host::SplitPlan plan = plan_of(mesh, 0.3f);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const double expected = expected_priority(mesh, box, i);
            if (std::abs(double{plan.priority(i)} - expected) > 1e-5 * expected) ++wrong;
        }
        CHECK(wrong == 0);
        CHECK(plan.priority(mesh.triangles.size() - 1) == 0.0f);
    }
}

TEST_CASE("quota_split: one factor for all, the largest that keeps the quota") {
    for (const float quota : {0.01f, 0.3f, 1.0f, 4.0f}) {
        INFO(quota);
        const Mesh mesh = generate_scene("hair", 5000);
        const host::SplitPlan plan = plan_of(mesh, quota);
        std::uint64_t planned = 0;
        // The factor is in [most, below): what each triangle's count says about it.
        double most = 0.0;
        double below = 1e300;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const double priority = plan.priority(i);
            planned += plan.splits(i);
            most = std::max(most, plan.splits(i) / priority);
            below = std::min(below, (plan.splits(i) + 1) / priority);
        }
        CHECK(most < below);
        CHECK(static_cast<double>(planned) <= double{quota} * 5000.0);
        CHECK(static_cast<double>(planned) > 0.999 * double{quota} * 5000.0 - 1.0);
        const host::PartBoxes parts = split(mesh, quota);
        CHECK(parts.source.size() <= 5000 + planned);
        CHECK(static_cast<double>(parts.source.size()) > 5000.0 + 0.9 * static_cast<double>(planned));
        CHECK(std::is_sorted(parts.source.begin(), parts.source.end()));
    }
}

TEST_CASE("quota_split: parts lie within their triangle's box, and are that box where nothing is split") {
    Mesh mesh = generate_scene("hair", 3000);
    deactivate_triangles(mesh, 5, 100);
    const host::SplitPlan plan = plan_of(mesh, 0.5f);
    const host::PartBoxes parts = split(mesh, 0.5f);
    std::vector<std::uint32_t> counts(mesh.triangles.size());
    for (std::size_t part = 0; part < parts.source.size(); ++part) {
        const std::uint32_t triangle = parts.source[part];
        ++counts[triangle];
        const Aabb whole = triangle_bounds(mesh, triangle);
        const Aabb box = parts.boxes[part];
        CHECK(merge(whole, box) == whole);
        if (plan.splits(triangle) == 0) CHECK(box == whole);
    }
    for (std::size_t i = 0; i < counts.size(); ++i) {
        const std::uint32_t most = is_inactive(mesh, i) ? 0 : plan.splits(i) + 1;
        CHECK(counts[i] <= most);
        CHECK((counts[i] > 0) == (most > 0));
    }
}

TEST_CASE("quota_split: every builder's tree over the parts is proven, whatever the mesh") {
    Mesh far = generate_scene("hair", 400);
    for (Vec3& vertex : far.vertices)
        vertex = {vertex.x + 1e4f, vertex.y, vertex.z - 1e4f};
    Mesh flat = generate_scene("hair", 400);
    for (Vec3& vertex : flat.vertices)
        vertex.z = 3.0f;
    Mesh some = generate_scene("hair", 400);
    deactivate_triangles(some, 0, 3);
    const std::vector<std::pair<const char*, Mesh>> meshes{
        {"none", {}},
        {"one", random_triangles(1)},
        {"two", random_triangles(2)},
        {"equal", coincident_triangles(500)},
        {"points", Mesh{{{1, 2, 3}}, std::vector<Triangle>(100)}},
        {"hair", generate_scene("hair", 2000)},
        {"far", far},
        {"flat", flat},
        {"some", some},
        {"tiny", scaled(generate_scene("hair", 400), 1e-38f)},
        {"huge", scaled(generate_scene("hair", 400), largest_scale(generate_scene("hair", 400)))},
    };
    for (const BuilderInfo& info : builders()) {
        if (!can_run(info.id)) continue;
        for (const auto& [name, mesh] : meshes) {
            for (const float quota : {0.3f, 4.0f}) {
                INFO(info.id << ", " << name << ", " << quota);
                const Bvh tree = make_builder(info.id, quota_options(quota)).build(mesh);
                CHECK(validate(tree, mesh).error == "");
                CHECK(tree.primitive_count == mesh.triangles.size());
            }
        }
    }
}

TEST_CASE("quota_split: one large triangle among small ones gets most of the splits") {
    Mesh mesh = random_triangles(1000);
    const Aabb box = scene_box(mesh);
    const auto vertex = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {box.lower, box.upper, {box.upper.x, box.lower.y, box.upper.z}});
    mesh.triangles.push_back({vertex, vertex + 1, vertex + 2});
    const host::SplitPlan plan = plan_of(mesh, 0.1f);
    CHECK(plan.splits(1000) > 10);
    const host::PartBoxes parts = split(mesh, 0.1f);
    // The parts' boxes around a diagonal triangle take far less surface than the whole's.
    double surface = 0.0;
    std::size_t count = 0;
    for (std::size_t part = 0; part < parts.source.size(); ++part) {
        if (parts.source[part] != 1000) continue;
        surface += double{half_area(parts.boxes[part])};
        ++count;
    }
    CHECK(count > 10);
    CHECK(surface < 0.75 * double{half_area(triangle_bounds(mesh, 1000))});
}

TEST_CASE("quota_split: the same bytes on any number of threads, and in memory that was used before") {
    const Mesh mesh = generate_scene("hair", 30000);
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 8);
    const host::PartBoxes expected = tbb::task_arena(1).execute([&] { return split(mesh, 0.3f); });
    for (const int threads : {2, 4, 7})
        CHECK(same(tbb::task_arena(threads).execute([&] { return split(mesh, 0.3f); }), expected));
    host::PartBoxes reused = split(generate_scene("hair", 40000), 1.0f);
    host::HostStages stages(kNoProgress);
    stages.begin("presplit", 0.0, 1.0);
    host::split_to_quota(mesh, 0.3f, stages, reused);
    CHECK(same(reused, expected));
}

TEST_CASE("quota_split: a quota out of range, or beside a level, is refused") {
    const auto expect_refused = [](const BuildOptions& options, const char* words) {
        expect_error(ErrorCode::invalid_input, {words}, [&] { static_cast<void>(make_builder("median", options)); });
    };
    expect_refused(quota_options(-0.1f), "split_quota is -0.1; it must be 0 to 4");
    expect_refused(quota_options(4.5f), "split_quota is 4.5; it must be 0 to 4");
    BuildOptions both = quota_options(0.3f);
    both.presplit_level = 14;
    expect_refused(both, "presplit_level and split_quota");
}

TEST_CASE("treelet-split: a build with it splits by the quota, optimises, and counts both") {
    const Mesh mesh = generate_scene("hair", 5000);
    for (const char* const id : {"lbvh", "median"}) {
        if (!can_run(id)) continue;
        INFO(id);
        BuildOptions options;
        options.max_leaf_size = 4;
        options.optimizers = "treelet";
        const double plain = sah_cost(make_builder(id, options).build(mesh));
        options.optimizers = "treelet-split";
        Builder builder = make_builder(id, options);
        CHECK(builder.options().split_quota == 0.3f);
        BuildStats stats;
        const Bvh tree = builder.build(mesh, &stats);
        CHECK(validate(tree, mesh).error == "");
        CHECK(tree.split_references);
        CHECK(tree.primitive_ids.size() <= 6500);
        CHECK(sah_cost(tree) < plain);
        CHECK(stage(stats, "presplit").host_ms > 0.0);
        CHECK(stage(stats, "treelet-split").host_ms > 0.0);

        BuildOptions by_hand = options;
        by_hand.optimizers = "treelet";
        by_hand.split_quota = 0.3f;
        CHECK(same_bytes(make_builder(id, by_hand).build(mesh), tree));
        options.split_quota = 0.1f;  // what the caller says counts
        CHECK(make_builder(id, options).build(mesh).primitive_ids.size() <= 5500);
        options.split_quota = 0.0f;
        options.presplit_level = 14;
        expect_error(ErrorCode::invalid_input, {"treelet-split", "presplit_level"},
                     [&] { static_cast<void>(make_builder(id, options)); });
    }
}

TEST_CASE("treelet-split: a finished tree is refused, with what to do instead") {
    const Mesh mesh = random_triangles(100);
    const Bvh tree = built_tree("lbvh", mesh);
    for (const char* const ids : {"treelet-split", "rotate,treelet-split"}) {
        expect_error(ErrorCode::invalid_input, {"treelet-split", "BuildOptions::optimizers", "split_quota", "treelet"},
                     [&] { static_cast<void>(optimize(tree, ids)); });
    }
    CHECK(find_optimizer("treelet-split").splits_first);
    CHECK_FALSE(find_optimizer("treelet").splits_first);
    CHECK_NOTHROW(check_optimizers("treelet-split,rotate"));
}
