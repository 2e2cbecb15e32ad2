#include "layout/octant_slots.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <set>

#include "core/random.hpp"

using namespace clbvh;
using namespace clbvh::layout;

namespace {

float cost(const Vec3& offset, std::uint32_t slot) {
    return ((slot & 4U) != 0 ? -offset.x : offset.x) + ((slot & 2U) != 0 ? -offset.y : offset.y) +
           ((slot & 1U) != 0 ? -offset.z : offset.z);
}

/// Again and again the cheapest of all pairs of a child and a free slot. Returns the sum of costs.
double greedy_sum(const std::array<Vec3, 8>& offsets, std::uint32_t count) {
    std::set<std::uint32_t> children, slots{0, 1, 2, 3, 4, 5, 6, 7};
    for (std::uint32_t child = 0; child < count; ++child)
        children.insert(child);
    double sum = 0.0;
    while (!children.empty()) {
        std::uint32_t best_child = 0, best_slot = 0;
        float best = std::numeric_limits<float>::infinity();
        for (const std::uint32_t child : children) {
            for (const std::uint32_t slot : slots) {
                if (cost(offsets[child], slot) >= best) continue;
                best = cost(offsets[child], slot);
                best_child = child;
                best_slot = slot;
            }
        }
        sum += best;
        children.erase(best_child);
        slots.erase(best_slot);
    }
    return sum;
}

OctantSlots slots_of(const std::array<Aabb, 8>& boxes, std::uint32_t count) {
    std::array<Box4, 8> loaded;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Aabb& box = boxes[i];
        loaded[i] = {Float4::of(box.lower.x, box.lower.y, box.lower.z),
                     Float4::of(box.upper.x, box.upper.y, box.upper.z)};
    }
    return {loaded, count};
}

}  // namespace

TEST_CASE("octant slots: eight boxes around a corner go each to the slot of its side") {
    std::array<Aabb, 8> boxes;
    for (std::uint32_t i = 0; i < 8; ++i) {
        const std::uint32_t side = i * 5 % 8;
        const Vec3 lower{(side & 4U) != 0 ? 1.0f : 0.0f, (side & 2U) != 0 ? 1.0f : 0.0f,
                         (side & 1U) != 0 ? 1.0f : 0.0f};
        boxes[i] = {lower, {lower.x + 1.0f, lower.y + 1.0f, lower.z + 1.0f}};
    }
    const OctantSlots slots = slots_of(boxes, 8);
    for (std::uint32_t i = 0; i < 8; ++i)
        CHECK(slots.child_in()[i * 5 % 8] == i);
}

TEST_CASE("octant slots: every child has one, and those with most to lose choose first") {
    Random random(7);
    for (std::uint32_t round = 0; round < 2000; ++round) {
        const std::uint32_t count = 1 + round % 8;
        std::array<Aabb, 8> boxes;
        Aabb all;
        for (std::uint32_t i = 0; i < count; ++i) {
            const Vec3 a = random.in_cube(-1.0f, 1.0f), b = random.in_cube(-1.0f, 1.0f);
            boxes[i] = {(min)(a, b), (max)(a, b)};
            all = merge(all, boxes[i]);
        }
        std::array<Vec3, 8> offsets;
        for (std::uint32_t i = 0; i < count; ++i) {
            const Vec3 own = doubled_centroid(boxes[i]), centre = doubled_centroid(all);
            offsets[i] = {own.x - centre.x, own.y - centre.y, own.z - centre.z};
        }
        const OctantSlots slots = slots_of(boxes, count);
        std::set<std::uint32_t> children;
        double sum = 0.0;
        for (std::uint32_t slot = 0; slot < 8; ++slot) {
            const std::uint32_t child = slots.child_in()[slot];
            if (child == kNoChild) continue;
            REQUIRE(child < count);
            children.insert(child);
            sum += cost(offsets[child], slot);
        }
        REQUIRE(children.size() == count);
        REQUIRE(sum == Approx(greedy_sum(offsets, count)).margin(1e-4));
    }
}

TEST_CASE("octant slots: boxes in one place, and boxes of NaN, have one each") {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float coordinate : {3.0f, nan}) {
        std::array<Aabb, 8> boxes;
        boxes.fill({{coordinate, 0, 0}, {coordinate, 1, 1}});
        const OctantSlots slots = slots_of(boxes, 8);
        CHECK(std::set<std::uint8_t>(slots.child_in().begin(), slots.child_in().end()).size() == 8);
        CHECK(*std::ranges::max_element(slots.child_in()) == 7);
    }
}
