#include "render/lighting.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <clbvh/builder.hpp>
#include <clbvh/core/vector.hpp>
#include <clbvh/io/scene.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "measure/ray_engine.hpp"
#include "render/denoise.hpp"
#include "render/light_sample.hpp"
#include "render/sample_sequence.hpp"

using namespace clbvh;
using namespace clbvh::tool;

namespace {

std::unique_ptr<RayEngine> engine_of(const Mesh& mesh) {
    return make_host_engine(Builder("binned-sah").build(mesh), mesh, {});
}

/// A box with the corners (-2, 0, -2) and (2, 3, 2), without its roof where it is open.
Mesh room(bool open) {
    Mesh mesh;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        mesh.vertices.push_back(
            {(corner & 1U) != 0 ? 2.0f : -2.0f, (corner & 2U) != 0 ? 3.0f : 0.0f, (corner & 4U) != 0 ? 2.0f : -2.0f});
    }
    mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5},
                      {0, 5, 4}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
    if (!open) mesh.triangles.insert(mesh.triangles.end(), {{2, 3, 7}, {2, 7, 6}});
    return mesh;
}

constexpr Camera kInRoom{{1.5f, 1.5f, 1.5f}, {-1, 1, -1}, {0, 1, 0}, 60.0f};

/// The mean over many samples of what arrives on the surface.
double mean_arrival(const Lighting& lighting, const Vec3& position, const Vec3& normal) {
    constexpr std::uint32_t samples = 40000;
    double sum = 0.0;
    for (std::uint32_t i = 0; i < samples; ++i) {
        SampleSequence random(5, i, 0);
        const auto sample = sample_light(lighting, position, normal, random);
        if (sample) sum += static_cast<double>(sample->light.y * std::max(0.0f, dot(normal, sample->direction)));
    }
    return sum / samples;
}

}  // namespace

TEST_CASE("choosing among lights gives what all of them give together") {
    Lighting all;
    all.to_sun = normalized({1, 2, 0});
    all.sunny_share = 0.3f;
    all.lamps = {{{0, 2, 0}, 0.1f, 3.0f}, {{2, 1, 1}, 0.2f, 3.0f}};
    const Vec3 position{0.3f, 0, 0.2f};
    const Vec3 normal{0, 1, 0};
    double sum = 0.0;
    for (int light = 0; light < 3; ++light) {
        Lighting alone;
        if (light == 2) {
            alone.to_sun = all.to_sun;
        } else {
            alone.lamps = {all.lamps[static_cast<std::size_t>(light)]};
        }
        sum += mean_arrival(alone, position, normal);
    }
    CHECK(mean_arrival(all, position, normal) == Approx(sum).epsilon(0.02));
    // The lamp right above: intensity over the square of the distance, times the cosine.
    Lighting above;
    above.lamps = {{{0, 2, 0}, 1e-3f, 3.0f}};
    CHECK(mean_arrival(above, {0, 0, 0}, normal) == Approx(3.0 / 4.0 * 0.93).epsilon(1e-3));
    SampleSequence random(1, 1, 1);
    CHECK(!sample_light(Lighting(), position, normal, random));
    CHECK(!sample_light(above, {0, 0, 0}, {0, -1, 0}, random));
}

TEST_CASE("a closed room is lit by lamps in it, and no sun") {
    const Mesh mesh = room(false);
    const Lighting lighting = fitting_lighting(mesh, kInRoom, *engine_of(mesh));
    CHECK(!lighting.to_sun);
    CHECK(!lighting.ground);
    REQUIRE(!lighting.lamps.empty());
    for (const Lamp& lamp : lighting.lamps) {
        CHECK(std::abs(lamp.centre.x) < 2.0f);
        CHECK(std::abs(lamp.centre.z) < 2.0f);
        CHECK(lamp.centre.y > 1.0f);
        CHECK(lamp.centre.y + lamp.radius < 3.0f);
    }
}

TEST_CASE("where a room is open, the sun shines in") {
    Mesh mesh = room(true);
    const std::unique_ptr<RayEngine> engine = engine_of(mesh);
    const Lighting lighting = fitting_lighting(mesh, kInRoom, *engine);
    REQUIRE(lighting.to_sun);
    CHECK(lighting.to_sun->y > 0.0f);
}

TEST_CASE("an object outside gets a sun, and a ground below it") {
    for (const Vec3 up : {Vec3{0, 1, 0}, Vec3{0, 0, -1}, normalized({1, 1, 1})}) {
        const Mesh ball = generate_scene("sphere", 2000);
        const Camera camera{{4, 3, 3}, {0, 0, 0}, up, 40.0f};
        const Lighting lighting = fitting_lighting(ball, camera, *engine_of(ball));
        CHECK(lighting.lamps.empty());
        REQUIRE(lighting.to_sun);
        CHECK(dot(*lighting.to_sun, up) > 0.5f);
        REQUIRE(lighting.ground);
        CHECK(*lighting.ground == Approx(-1.0).margin(0.02));
    }
}

TEST_CASE("smoothing keeps edges of planes and of light that is sure, and drops noise") {
    constexpr std::uint32_t width = 64;
    constexpr std::uint32_t height = 32;
    LitPicture picture(width, height);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::size_t i = std::size_t{y} * width + x;
            const float noise = SampleSequence(1, i, 0).next().first - 0.5f;
            const bool left = x < 32;
            const float light = left ? 1.0f : 3.0f;
            picture.light.pixels()[i] = Vec3{1, 1, 1} * (light + noise);
            picture.variance[i] = 1.0f / 12.0f;
            picture.albedo.pixels()[i] = {1, 1, 1};
            picture.normal.pixels()[i] = left ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
            picture.position.pixels()[i] = {static_cast<float>(x), static_cast<float>(y), 0};
            picture.is_surface[i] = 1;
        }
    }
    denoise(picture);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x)
            CHECK(picture.light.at(x, y).y == Approx(x < 32 ? 1.0 : 3.0).margin(0.35));
    }
}
