#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <string>

#include "clbvh/core/error.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/io/scene.hpp"
#include "core/random.hpp"
#include "io/sphere.hpp"

namespace clbvh {
namespace {

std::uint32_t push_vertex(Mesh& mesh, const Vec3& vertex) {
    mesh.vertices.push_back(vertex);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void push_triangle(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c) {
    const std::uint32_t first = push_vertex(mesh, a);
    push_vertex(mesh, b);
    push_vertex(mesh, c);
    mesh.triangles.push_back({first, first + 1, first + 2});
}

/// A triangle with its corners at random in a cube around `centre`.
void push_random_triangle(Mesh& mesh, Random& random, const Vec3& centre, float half_size) {
    const Vec3 a = centre + random.in_cube(-half_size, half_size);
    const Vec3 b = centre + random.in_cube(-half_size, half_size);
    const Vec3 c = centre + random.in_cube(-half_size, half_size);
    push_triangle(mesh, a, b, c);
}

/// The least n > 0 with n * n >= value.
std::uint32_t square_root_up(std::uint64_t value) {
    std::uint64_t root = 1;
    while (root * root < value)
        ++root;
    return static_cast<std::uint32_t>(root);
}

/// The least n > 0 with n * n * n >= value.
std::uint32_t cube_root_up(std::uint64_t value) {
    std::uint64_t root = 1;
    while (root * root * root < value)
        ++root;
    return static_cast<std::uint32_t>(root);
}

/// Half the edge of a cube's share of the unit cube, where `count` of them fill it.
float half_share(std::uint64_t count) {
    return 0.5f / static_cast<float>(cube_root_up(count));
}

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

/// Appends the two triangles of a parallelogram, as far as there is room below `count`.
void push_quad(Mesh& mesh, std::uint64_t count, const Vec3& corner, const Vec3& along, const Vec3& across) {
    const Vec3 opposite = corner + along + across;
    if (mesh.triangles.size() < count) push_triangle(mesh, corner, corner + along, opposite);
    if (mesh.triangles.size() < count) push_triangle(mesh, corner, opposite, corner + across);
}

/// The walls and the roof of a building whose least corner is `at`.
void push_building(Mesh& mesh, std::uint64_t count, const Vec3& at, const Vec3& size) {
    const Vec3 x{size.x, 0, 0};
    const Vec3 y{0, size.y, 0};
    const Vec3 z{0, 0, size.z};
    push_quad(mesh, count, at, x, y);
    push_quad(mesh, count, at + z, x, y);
    push_quad(mesh, count, at, z, y);
    push_quad(mesh, count, at + x, z, y);
    push_quad(mesh, count, at + y, x, z);
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
    Mesh (*make)(std::uint64_t count, std::uint64_t seed) = nullptr;
};

constexpr std::array kGenerators{
    Generator{{"soup", "small triangles, uniform in a cube"}, make_soup},
    Generator{{"clustered", "small triangles in 100 clusters of very different size and crowd"}, make_clustered},
    Generator{{"terrain", "a smooth heightfield of equal triangles"}, make_terrain},
    Generator{{"city", "few huge triangles (ground, buildings) beside very many tiny ones"}, make_city},
    Generator{{"hair", "long, thin, diagonal, overlapping triangles"}, make_hair},
    Generator{{"particles", "many triangles with the same box: half of all, and groups of some 256"}, make_particles},
    Generator{{"line", "triangles whose centroids are collinear"}, make_line},
    Generator{{"sphere", "a tessellated sphere, closed for even counts from 8; the seed has no effect"},
              [](std::uint64_t count, std::uint64_t) { return io::make_sphere(count); }},
};

constexpr auto kInfos = [] {
    std::array<SceneGeneratorInfo, kGenerators.size()> infos{};
    std::ranges::transform(kGenerators, infos.begin(), &Generator::info);
    return infos;
}();

const Generator& find_generator(std::string_view name) {
    std::string known;
    for (const Generator& generator : kGenerators) {
        if (generator.info.name == name) return generator;
        known += (known.empty() ? "" : ", ") + std::string(generator.info.name);
    }
    throw Error(ErrorCode::invalid_input, "unknown scene generator \"" + std::string(name) + "\"; there are: " + known);
}

}  // namespace

std::span<const SceneGeneratorInfo> scene_generators() noexcept {
    return kInfos;
}

Mesh generate_scene(std::string_view name, std::uint64_t count, std::uint64_t seed) {
    const Generator& generator = find_generator(name);
    if (count > kMaxPrimitives) {
        throw Error(ErrorCode::invalid_input, "a scene of " + std::to_string(count) +
                                                  " triangles is over the limit of " + std::to_string(kMaxPrimitives));
    }
    try {
        return generator.make(count, seed);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "not enough memory for " + std::to_string(count) + " triangles");
    }
}

}  // namespace clbvh
