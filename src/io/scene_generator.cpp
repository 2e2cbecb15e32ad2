#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <sstream>
#include <string>
#include <system_error>

#include "clbvh/core/error.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/io/scene.hpp"
#include "io/mesh_pieces.hpp"
#include "io/scene_generator.hpp"
#include "io/sphere.hpp"
#include "io/wide_scenes.hpp"

namespace clbvh {
namespace {

using namespace io;

Mesh make_soup(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    Mesh mesh;
    mesh.vertices.reserve(3 * count);
    mesh.triangles.reserve(count);
    const float half_size = half_share(count);
    for (std::uint64_t i = 0; i < count; ++i)
        push_random_triangle(mesh, random, random.in_cube(0, 1), half_size);
    return mesh;
}

Mesh make_clustered(std::uint64_t count, std::uint64_t seed) {
    struct Cluster {
        Vec3 centre;
        float radius = 0.0f;
    };
    Random random(seed);
    std::array<Cluster, 100> clusters;
    for (Cluster& cluster : clusters) {
        const float u = random.unit();
        cluster = {random.in_cube(0, 1), 0.001f + 0.1f * u * u * u};
    }
    Mesh mesh;
    mesh.vertices.reserve(3 * count);
    mesh.triangles.reserve(count);
    const float half_size = half_share(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        // Low numbers are drawn more often: some clusters are crowded, some nearly empty.
        const Cluster& cluster = clusters[random.below(random.below(clusters.size()) + 1)];
        const float x = random.bell();
        const float y = random.bell();
        const float z = random.bell();
        push_random_triangle(mesh, random, cluster.centre + cluster.radius * Vec3{x, y, z}, cluster.radius * half_size);
    }
    return mesh;
}

/// A number in [0, 1) for each point of the integer lattice.
float lattice_noise(std::uint32_t x, std::uint32_t y, std::uint64_t seed) {
    Random random(seed ^ (std::uint64_t{x} << 32 | y));
    return random.unit();
}

/// Smooth noise in [0, 1): the lattice's numbers, blended with a zero slope at every lattice point.
float smooth_noise(float x, float y, std::uint64_t seed) {
    const auto column = static_cast<std::uint32_t>(x);
    const auto row = static_cast<std::uint32_t>(y);
    const float u = x - static_cast<float>(column);
    const float v = y - static_cast<float>(row);
    const float s = u * u * (3 - 2 * u);
    const float t = v * v * (3 - 2 * v);
    const float near = lattice_noise(column, row, seed) * (1 - s) + lattice_noise(column + 1, row, seed) * s;
    const float far = lattice_noise(column, row + 1, seed) * (1 - s) + lattice_noise(column + 1, row + 1, seed) * s;
    return near * (1 - t) + far * t;
}

float terrain_height(float x, float z, std::uint64_t seed) {
    return 0.1f * smooth_noise(3 * x, 3 * z, seed) + 0.02f * smooth_noise(11 * x, 11 * z, seed + 1) +
           0.005f * smooth_noise(37 * x, 37 * z, seed + 2);
}

/// Two triangles a cell, row by row; the last row may end early.
Mesh make_terrain(std::uint64_t count, std::uint64_t seed) {
    const std::uint64_t cells = (count + 1) / 2;
    const std::uint32_t columns = square_root_up(cells);
    const auto rows = static_cast<std::uint32_t>((cells + columns - 1) / columns);
    Mesh mesh;
    mesh.vertices.reserve((columns + 1ULL) * (rows + 1ULL));
    mesh.triangles.reserve(count);
    for (std::uint32_t row = 0; row <= rows; ++row) {
        for (std::uint32_t column = 0; column <= columns; ++column) {
            const float x = static_cast<float>(column) / static_cast<float>(columns);
            const float z = static_cast<float>(row) / static_cast<float>(columns);
            push_vertex(mesh, {x, terrain_height(x, z, seed), z});
        }
    }
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t cell = i / 2;
        const auto corner = static_cast<std::uint32_t>(cell / columns * (columns + 1) + cell % columns);
        const std::uint32_t below = corner + columns + 1;
        if (i % 2 == 0) mesh.triangles.push_back({corner, below, corner + 1});
        if (i % 2 == 1) mesh.triangles.push_back({corner + 1, below, below + 1});
    }
    return mesh;
}

/// Ground of two triangles under square blocks, a thousand triangles each: a building of ten, tiny ones around it.
Mesh make_city(std::uint64_t count, std::uint64_t seed) {
    constexpr std::uint64_t kTrianglesPerBlock = 1000;
    Random random(seed);
    Mesh mesh;
    mesh.vertices.reserve(3 * count);
    mesh.triangles.reserve(count);
    const std::uint32_t side = square_root_up((count + kTrianglesPerBlock - 1) / kTrianglesPerBlock);
    const auto extent = static_cast<float>(side);
    push_quad(mesh, count, {0, 0, 0}, {extent, 0, 0}, {0, 0, extent});
    for (std::uint32_t block = 0; mesh.triangles.size() < count; ++block) {
        const std::uint32_t row = block / side;
        const Vec3 corner{static_cast<float>(block % side), 0, static_cast<float>(row)};
        const float u = random.unit();
        const Vec3 size{random.between(0.4f, 0.7f), 0.2f + 5 * u * u * u, random.between(0.4f, 0.7f)};
        push_building(mesh, count, corner + Vec3{0.15f, 0, 0.15f}, size);
        const std::uint64_t details = std::min(kTrianglesPerBlock - 10, count - mesh.triangles.size());
        for (std::uint64_t i = 0; i < details; ++i) {
            const Vec3 place{random.unit(), 0.01f + size.y * random.unit() * random.unit(), random.unit()};
            push_random_triangle(mesh, random, corner + place, 0.005f);
        }
    }
    return mesh;
}

Mesh make_hair(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    Mesh mesh;
    mesh.vertices.reserve(3 * count);
    mesh.triangles.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        const Vec3 root = random.in_cube(0, 1);
        const float length = random.between(0.2f, 0.4f);
        const Vec3 along = Vec3{1, 1, 1} + random.in_cube(-0.3f, 0.3f);
        const Vec3 width{0.0005f, -0.0005f, 0};
        push_triangle(mesh, root, root + width, root + length * along);
    }
    return mesh;
}

/// Every second triangle is the same one; the others belong to emitters of 256 or more equal triangles.
Mesh make_particles(std::uint64_t count, std::uint64_t seed) {
    constexpr std::uint64_t kTrianglesPerEmitter = 256;
    Random random(seed);
    Mesh mesh;
    const std::uint64_t emitters = std::max<std::uint64_t>(1, count / 2 / kTrianglesPerEmitter);
    mesh.vertices.reserve(3 * (1 + emitters));
    mesh.triangles.reserve(count);
    for (std::uint64_t i = 0; i < 1 + emitters; ++i) {
        const Vec3 centre = random.in_cube(0, 1);
        push_vertex(mesh, centre + Vec3{-0.01f, -0.01f, 0});
        push_vertex(mesh, centre + Vec3{0.01f, -0.01f, 0});
        push_vertex(mesh, centre + Vec3{0, 0.01f, 0.01f});
    }
    for (std::uint64_t i = 0; i < count; ++i) {
        const auto first = static_cast<std::uint32_t>(i % 2 == 0 ? 0 : 3 * (1 + i / 2 % emitters));
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

/// All boxes are symmetric to the x axis, so that the centroids are on it to the last bit.
Mesh make_line(std::uint64_t count, std::uint64_t seed) {
    Random random(seed);
    Mesh mesh;
    mesh.vertices.reserve(3 * count);
    mesh.triangles.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
        const float x = random.unit();
        const float length = random.between(0.0001f, 0.01f);
        const float y = random.between(0.001f, 0.01f);
        const float z = random.between(0.001f, 0.01f);
        push_triangle(mesh, {x - length, -y, -z}, {x + length, y, -z}, {x - length, y, z});
    }
    return mesh;
}

struct Generator {
    SceneGeneratorInfo info;
    Mesh (*make)(std::uint64_t count, std::uint64_t seed, double parameter) = nullptr;
};

/// A generator without a parameter.
template <Mesh (*Make)(std::uint64_t, std::uint64_t)>
Mesh plain(std::uint64_t count, std::uint64_t seed, double) {
    return Make(count, seed);
}

constexpr std::array kGenerators{
    Generator{{"soup", "small triangles, uniform in a cube"}, plain<make_soup>},
    Generator{{"clustered", "small triangles in 100 clusters of very different size and crowd"}, plain<make_clustered>},
    Generator{{"terrain", "a smooth heightfield of equal triangles"}, plain<make_terrain>},
    Generator{{"city", "few huge triangles (ground, buildings) beside very many tiny ones"}, plain<make_city>},
    Generator{{"hair", "long, thin, diagonal, overlapping triangles"}, plain<make_hair>},
    Generator{{"particles", "many triangles with the same box: half of all, and groups of some 256"},
              plain<make_particles>},
    Generator{{"line", "triangles whose centroids are collinear"}, plain<make_line>},
    Generator{{"sphere", "a tessellated sphere, closed for even counts from 8; the seed has no effect"},
              [](std::uint64_t count, std::uint64_t, double) { return make_sphere(count); }},
    Generator{
        {"outlier", "small triangles in a unit cube, and one far away", {"D", "its three coordinates", 1e6, 1e12, 10}},
        make_outlier},
    Generator{{"planes", "small triangles in a unit cube, on a ground and before walls 1000 times as large"},
              plain<make_planes>},
    Generator{{"sky", "small triangles in a unit cube, within a sphere 1000 times as large"}, plain<make_sky>},
    Generator{{"two-objects",
               "two unit cubes of small triangles, far from each other",
               {"D", "their distance", 1e6, 1e12, 10}},
              make_two_objects},
    Generator{{"planet", "a globe in metres around the origin, and a town on it"}, plain<make_planet>},
    Generator{{"mixed",
               "cubes of small triangles in one corner, each a tenth of the one before",
               {"K", "orders of magnitude", 6, 12, 0}},
              make_mixed},
    Generator{{"scanlike", "a ball with bumps of many sizes, of even triangles, as scans are"}, plain<make_scanlike>},
};

constexpr auto kInfos = [] {
    std::array<SceneGeneratorInfo, kGenerators.size()> infos{};
    std::ranges::transform(kGenerators, infos.begin(), &Generator::info);
    return infos;
}();

const Generator* find_generator(std::string_view name) noexcept {
    const auto found = std::ranges::find(kGenerators, name, [](const Generator& g) { return g.info.name; });
    return found == kGenerators.end() ? nullptr : &*found;
}

/// A generator, and the text behind the colon where there is one.
struct NamedGenerator {
    const Generator* generator;
    std::string_view parameter;
};

NamedGenerator parse_name(std::string_view name) noexcept {
    const std::size_t colon = std::min(name.find(':'), name.size());
    return {find_generator(name.substr(0, colon)), name.substr(std::min(colon + 1, name.size()))};
}

/// No number in the parameter's range: NaN.
double number_of(const SceneParameter& parameter, std::string_view text) noexcept {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_number = error == std::errc{} && end == text.data() + text.size();
    const bool is_possible = is_number && value >= parameter.least && value <= parameter.most;
    return is_possible ? value : std::numeric_limits<double>::quiet_NaN();
}

std::string fault_of_parameter(const SceneGeneratorInfo& info, std::string_view text) {
    const SceneParameter& parameter = info.parameter;
    const std::string generator = "scene generator \"" + std::string(info.name) + "\"";
    if (parameter.name.empty()) return generator + " has no parameter";
    if (!std::isnan(number_of(parameter, text))) return {};
    std::ostringstream fault;
    fault << generator << ": " << parameter.name << ", " << parameter.description << ", is \"" << text
          << "\", which is not " << parameter.least << " to " << parameter.most;
    return fault.str();
}

}  // namespace

std::string io::standard_parameter(std::string_view generator) {
    const Generator* const found = find_generator(generator);
    if (found == nullptr || found->info.parameter.name.empty()) return {};
    std::ostringstream text;
    text << found->info.parameter.standard;
    return text.str();
}

std::string io::fault_of_scene(std::string_view name, std::uint64_t count) {
    const auto [generator, parameter] = parse_name(name);
    if (generator == nullptr) {
        std::string known;
        for (const SceneGeneratorInfo& info : kInfos)
            known += (known.empty() ? "" : ", ") + std::string(info.name);
        return "unknown scene generator \"" + std::string(name) + "\"; there are: " + known;
    }
    if (count > kMaxPrimitives) {
        return "a scene of " + std::to_string(count) + " triangles is over the limit of " +
               std::to_string(kMaxPrimitives);
    }
    return name.find(':') == std::string_view::npos ? std::string() : fault_of_parameter(generator->info, parameter);
}

std::span<const SceneGeneratorInfo> scene_generators() noexcept {
    return kInfos;
}

Mesh generate_scene(std::string_view name, std::uint64_t count, std::uint64_t seed) {
    const std::string fault = io::fault_of_scene(name, count);
    if (!fault.empty()) throw Error(ErrorCode::invalid_input, fault);
    const auto [generator, text] = parse_name(name);
    const SceneParameter& parameter = generator->info.parameter;
    const double value = text.empty() ? parameter.standard : number_of(parameter, text);
    try {
        return generator->make(count, seed, value);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "not enough memory for " + std::to_string(count) + " triangles");
    }
}

}  // namespace clbvh
