#include "support/layout_rays.hpp"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "support/oracle/ray_oracle.hpp"

namespace clbvh::test {
namespace {

/// One node, byte by byte.
class NodeBytes {
public:
    NodeBytes(const void* nodes, std::size_t number, std::size_t size)
        : bytes_(static_cast<const std::byte*>(nodes) + number * size) {}

    [[nodiscard]] std::uint32_t word(std::size_t offset) const {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value |= std::to_integer<std::uint32_t>(bytes_[offset + i]) << (8 * i);
        return value;
    }
    [[nodiscard]] std::uint32_t byte(std::size_t offset) const {
        return std::to_integer<std::uint32_t>(bytes_[offset]);
    }
    [[nodiscard]] float number(std::size_t offset) const { return std::bit_cast<float>(word(offset)); }
    [[nodiscard]] Vec3 point(std::size_t offset) const {
        return {number(offset), number(offset + 4), number(offset + 8)};
    }

private:
    const std::byte* bytes_;
};

/// The closest hit so far.
class Search {
public:
    Search(const Mesh& mesh, const Ray& ray) : mesh_(mesh), ray_(ray), rest_(ray) {}

    [[nodiscard]] bool meets(const Aabb& box) const { return entry_of_box(box, rest_).has_value(); }

    void test(std::uint32_t primitive) {
        const std::optional<Hit> hit = hit_of_triangle(mesh_, primitive, ray_);
        if (!hit || hit->t > hit_.t || (hit->t == hit_.t && primitive >= hit_.primitive)) return;
        hit_ = *hit;
        rest_.t_max = hit->t;
    }

    [[nodiscard]] const Hit& hit() const { return hit_; }

private:
    const Mesh& mesh_;
    Ray ray_;
    Ray rest_;  ///< What is left of it before the hit.
    Hit hit_;
};

/// A box around the one of `slot`, somewhat larger where floats cannot tell it exactly.
Aabb box_around(const NodeBytes& node, std::size_t slot) {
    const Vec3 origin = node.point(0);
    const auto plane = [&](float from, std::size_t axis, std::size_t first) {
        const int exponent = static_cast<std::int8_t>(node.byte(12 + axis));
        const std::uint32_t q = node.byte(first + 8 * axis + slot);
        return static_cast<float>(static_cast<double>(from) + std::ldexp(static_cast<double>(q), exponent));
    };
    const auto less = [](float x) { return std::nextafter(x, -INFINITY); };
    const auto more = [](float x) { return std::nextafter(x, INFINITY); };
    return {{less(plane(origin.x, 0, 32)), less(plane(origin.y, 1, 32)), less(plane(origin.z, 2, 32))},
            {more(plane(origin.x, 0, 56)), more(plane(origin.y, 1, 56)), more(plane(origin.z, 2, 56))}};
}

/// The children of a node that the search meets are put on the stack so that they come back in the order of their
/// slots XOR `octant`, or the other way around. Triangles of leaves are tested at once.
std::size_t search_compressed8(const Compressed8& layout, Search& search, std::uint32_t octant, bool backwards) {
    std::size_t visited = 0;
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const NodeBytes node(layout.nodes.data(), stack.back(), 80);
        stack.pop_back();
        ++visited;
        const std::uint32_t inner_mask = node.byte(15), first_child = node.word(16), first_triangle = node.word(20);
        for (std::uint32_t place = 0; place < 8; ++place) {
            const std::uint32_t slot = (backwards ? place : 7 - place) ^ octant;
            const std::uint32_t meta = node.byte(24 + slot);
            if (meta == 0 || !search.meets(box_around(node, slot))) continue;
            if ((inner_mask >> slot & 1U) != 0) {
                std::uint32_t before = 0;
                for (std::uint32_t other = 0; other < slot; ++other)
                    before += inner_mask >> other & 1U;
                stack.push_back(first_child + before);
                continue;
            }
            for (std::uint32_t i = 0; (meta >> (5 + i) & 1U) != 0 && i < 3; ++i) {
                const std::uint32_t number = first_triangle / 3 + (meta & 31U) + i;
                search.test(NodeBytes(layout.triangles.data(), number, 48).word(44));
            }
        }
    }
    return visited;
}

/// The triangles of blocks are taken from the mesh, by their numbers.
Hit search_wide(const void* nodes, const void* blocks, std::size_t width, const Mesh& mesh, const Ray& ray) {
    Search search(mesh, ray);
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const NodeBytes node(nodes, stack.back(), 28 * width);
        stack.pop_back();
        for (std::size_t slot = 0; slot < width; ++slot) {
            const std::uint32_t child = node.word(24 * width + 4 * slot);
            const auto corner = [&](std::size_t side) {
                const std::size_t x = 12 * width * side + 4 * slot;
                return Vec3{node.number(x), node.number(x + 4 * width), node.number(x + 8 * width)};
            };
            if (child == 0xFFFFFFFF || !search.meets({corner(0), corner(1)})) continue;
            if (child >> 31U == 0) {
                stack.push_back(child);
                continue;
            }
            for (std::uint32_t i = 0; i <= (child >> 28U & 7U); ++i) {
                const NodeBytes block(blocks, (child & 0xFFFFFFFU) + i, 160);
                for (std::size_t lane = 0; lane < 4; ++lane)
                    if (block.word(144 + 4 * lane) != 0xFFFFFFFF) search.test(block.word(144 + 4 * lane));
            }
        }
    }
    return search.hit();
}

std::uint32_t octant_of(const Ray& ray) {
    return (ray.direction.x < 0.0f ? 4U : 0U) | (ray.direction.y < 0.0f ? 2U : 0U) | (ray.direction.z < 0.0f ? 1U : 0U);
}

}  // namespace

Hit closest_in(const SkipLayout& layout, const Mesh& mesh, const Ray& ray) {
    if (hits_nothing(ray)) return {};
    Search search(mesh, ray);
    for (std::size_t i = 0; i < layout.nodes.size();) {
        const NodeBytes node(layout.nodes.data(), i, 32);
        const std::uint32_t link = node.word(12), count = node.word(28);
        const bool is_met = search.meets({node.point(0), node.point(16)});
        for (std::uint32_t k = 0; is_met && k < count; ++k)
            search.test(layout.primitive_ids[link + k]);
        i = is_met || count > 0 ? i + 1 : link;
    }
    return search.hit();
}

Hit closest_in(const PairLayout& layout, const Mesh& mesh, const Ray& ray) {
    if (hits_nothing(ray) || layout.empty()) return {};
    Search search(mesh, ray);
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const NodeBytes node(layout.nodes.data(), stack.back(), 64);
        stack.pop_back();
        const std::uint32_t count = node.word(44), first = node.word(60);
        for (std::uint32_t k = 0; k < count; ++k)
            search.test(layout.primitive_ids[first + k]);
        if (count > 0) continue;
        if (search.meets({node.point(32), node.point(48)})) stack.push_back(node.word(28));
        if (search.meets({node.point(0), node.point(16)})) stack.push_back(node.word(12));
    }
    return search.hit();
}

Hit closest_in(const Compressed8& layout, const Mesh& mesh, const Ray& ray) {
    if (hits_nothing(ray) || layout.empty()) return {};
    Search search(mesh, ray);
    search_compressed8(layout, search, octant_of(ray), false);
    return search.hit();
}

Hit closest_in(const Wide8& layout, const Mesh& mesh, const Ray& ray) {
    if (hits_nothing(ray) || layout.empty()) return {};
    return search_wide(layout.nodes.data(), layout.blocks.data(), 8, mesh, ray);
}

Hit closest_in(const Wide4& layout, const Mesh& mesh, const Ray& ray) {
    if (hits_nothing(ray) || layout.empty()) return {};
    return search_wide(layout.nodes.data(), layout.blocks.data(), 4, mesh, ray);
}

OrderCosts order_costs(const Compressed8& layout, const Mesh& mesh, const Ray& ray) {
    Search search(mesh, ray), other(mesh, ray);
    return {search_compressed8(layout, search, octant_of(ray), false),
            search_compressed8(layout, other, octant_of(ray), true)};
}

}  // namespace clbvh::test
