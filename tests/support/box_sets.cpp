#include "support/box_sets.hpp"

#include <cmath>
#include <random>

namespace clbvh::test {
namespace {

/// Uniform in [-1, 1), from the generator's bits alone, so that every standard library gives the same.
float uniform(std::mt19937& random) {
    return static_cast<float>(random() >> 8) / 8388608.0f - 1.0f;
}

Vec3 uniform_vector(std::mt19937& random, float extent) {
    const float x = uniform(random) * extent;
    const float y = uniform(random) * extent;
    const float z = uniform(random) * extent;
    return {x, y, z};
}

Aabb box_around(const Vec3& centre, const Vec3& radius) {
    const Vec3 r{std::abs(radius.x), std::abs(radius.y), std::abs(radius.z)};
    return {{centre.x - r.x, centre.y - r.y, centre.z - r.z}, {centre.x + r.x, centre.y + r.y, centre.z + r.z}};
}

template <typename MakeBox>
BoxSet make_set(std::string name, std::size_t count, const MakeBox& make_box) {
    std::mt19937 random(7);
    BoxSet set{std::move(name), {}};
    for (std::size_t i = 0; i < count; ++i)
        set.boxes.push_back(make_box(random, static_cast<float>(i)));
    return set;
}

std::vector<Aabb> scaled(std::vector<Aabb> boxes, float scale) {
    for (Aabb& box : boxes) {
        box = {{box.lower.x * scale, box.lower.y * scale, box.lower.z * scale},
               {box.upper.x * scale, box.upper.y * scale, box.upper.z * scale}};
    }
    return boxes;
}

}  // namespace

std::vector<Aabb> random_boxes(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 centre = uniform_vector(random, 10.0f);
        boxes.push_back(box_around(centre, uniform_vector(random, 0.5f)));
    }
    return boxes;
}

std::vector<Aabb> grid_boxes(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto coordinate = [&](std::uint32_t cells) { return static_cast<float>(random() % cells); };
    std::vector<Aabb> boxes;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 lower{coordinate(8), coordinate(8), coordinate(4)};
        const Vec3 size{coordinate(2), coordinate(2), coordinate(2)};
        boxes.push_back({lower, {lower.x + size.x, lower.y + size.y, lower.z + size.z}});
    }
    return boxes;
}

std::vector<BoxSet> hard_box_sets(std::size_t count) {
    const auto whole = static_cast<float>(count);
    std::vector<BoxSet> sets;
    sets.push_back(make_set("equal boxes", count, [](auto&, float) { return Aabb{{1, 2, 3}, {2, 3.5f, 4.3f}}; }));
    sets.push_back(make_set("one point", count, [](auto&, float) { return Aabb{{1, 2, 3}, {1, 2, 3}}; }));
    sets.push_back(make_set("concentric boxes", count,
                            [](auto& random, float) { return box_around({}, uniform_vector(random, 3.0f)); }));
    sets.push_back(make_set("points on a line", count, [](auto&, float i) { return Aabb{{i, 0, 0}, {i, 0, 0}}; }));
    sets.push_back(make_set("points on a diagonal", count, [](auto&, float i) { return Aabb{{i, i, i}, {i, i, i}}; }));
    sets.push_back(make_set("flat boxes in one plane", count, [](auto& random, float) {
        const Vec3 centre = uniform_vector(random, 10.0f);
        return box_around({centre.x, 1, centre.z}, {uniform(random), 0, uniform(random)});
    }));
    sets.push_back(make_set("one huge box among tiny ones", count, [](auto& random, float i) {
        return i == 5 ? box_around({}, {1e9f, 1e9f, 1e9f}) : box_around(uniform_vector(random, 1.0f), {});
    }));
    sets.push_back(make_set("powers of two", count, [&](auto&, float i) {
        const float x = std::exp2(-120.0f * i / whole);
        return Aabb{{x, 0, 0}, {x, x, x}};
    }));
    sets.push_back(make_set("growing nested boxes", count, [&](auto&, float i) {
        return Aabb{{0, 0, 0}, {1 + i, 1 + i, 1 + i}};
    }));
    sets.push_back({"a coarse grid", grid_boxes(count)});
    sets.push_back({"the largest coordinates", scaled(random_boxes(count), 0.9e17f)});
    sets.push_back({"half areas next to the smallest float", scaled(random_boxes(count), 1e-22f)});
    sets.push_back({"coordinates next to the smallest float", scaled(random_boxes(count), 1e-42f)});
    return sets;
}

Mesh mesh_of_boxes(std::span<const Aabb> boxes) {
    Mesh mesh;
    for (const Aabb& box : boxes) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {box.lower, box.upper});
        mesh.triangles.push_back({first, first + 1, first});
    }
    return mesh;
}

}  // namespace clbvh::test
