#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "clbvh/core/aabb.hpp"
#include "core/simd/box4.hpp"
#include "layout/lanes.hpp"

namespace clbvh::layout {

inline constexpr std::uint8_t kNoChild = 0xFF;

/// Puts up to eight children of a node into slots, so that a ray's octant tells in which order it had better visit
/// them: Ylitie, Karras, Laine 2017, section 3.2. A child on the lower side of an axis wants a slot without that axis'
/// bit (4: x, 2: y, 1: z). The paper finds the best assignment by auction. Here children choose one after the other,
/// always the one that is farthest from the node's centre along the diagonal of its best free slot, in the L1 norm.
class OctantSlots {
public:
    /// boxes[0 .. count) are the children's.
    OctantSlots(const std::array<Box4, 8>& boxes, std::uint32_t count) {
        child_in_.fill(kNoChild);
        Box4 all;
        for (std::uint32_t child = 0; child < count; ++child)
            all.merge(boxes[child]);
        const Float4 centre = all.doubled_centroid();
        for (std::uint32_t half = 0; half < 2; ++half)
            want_octants(boxes.data() + std::size_t{4} * half, centre, half);
        for (std::uint32_t child = count; child < 8; ++child)
            raise(costs_, child, kPositiveInfinity);
        for (std::uint32_t left = count; left > 0;)
            left -= give_slot() ? 1 : 0;
    }

    /// Which child is in each slot, or kNoChild.
    [[nodiscard]] const std::array<std::uint8_t, 8>& child_in() const noexcept { return child_in_; }

private:
    /// Of boxes that no builder makes it may be anything; here it is finite.
    static Float4 finite(Float4 x) noexcept {
        constexpr float most = 1e30f;
        return min(max(x, Float4::filled(-most)), Float4::filled(most));
    }

    /// In two vectors that stay in registers: a load of what was just stored in parts would have to wait for it.
    using Floats8 = std::array<Float4, 2>;

    /// To `value` in one lane, which has no more than that.
    static void raise(Floats8& lanes, std::uint32_t lane, float value) noexcept {
        for (std::uint32_t half = 0; half < 2; ++half)
            lanes[half] = max(lanes[half], min(Float4::filled(value), lane_of_eight(lane, half)));
    }

    /// Four children, without a look at the others: each wants the slot of the side that it is on.
    void want_octants(const Box4* boxes, Float4 centre, std::uint32_t half) {
        const std::uint32_t begin = 4 * half;
        Float4 x = boxes[0].doubled_centroid() - centre, y = boxes[1].doubled_centroid() - centre;
        Float4 z = boxes[2].doubled_centroid() - centre, w = boxes[3].doubled_centroid() - centre;
        Float4::transpose(x, y, z, w);
        x = finite(x);
        y = finite(y);
        z = finite(z);
        x.store(x_.data() + begin);
        y.store(y_.data() + begin);
        z.store(z_.data() + begin);
        costs_[half] = (min(x, x.negated()) + min(y, y.negated())) + min(z, z.negated());
        const Float4 zero = Float4::filled(0.0f);
        const std::uint32_t above_x = less(zero, x).bits(), above_y = less(zero, y).bits(),
                            above_z = less(zero, z).bits();
        for (std::uint32_t i = 0; i < 4; ++i)
            slots_[begin + i] = (above_x >> i & 1U) << 2U | (above_y >> i & 1U) << 1U | (above_z >> i & 1U);
    }

    /// To the child with the least cost, if the slot that it wants is free; else it wants another. Costs only rise as
    /// slots are taken, so that the least is never one that has to rise.
    bool give_slot() {
        const std::uint32_t child = first_least(costs_[0], costs_[1]);
        const std::uint32_t slot = slots_[child];
        if (child_in_[slot] != kNoChild) {
            want_free_slot(child);
            return false;
        }
        child_in_[slot] = static_cast<std::uint8_t>(child);
        raise(taken_, slot, kPositiveInfinity);
        raise(costs_, child, kPositiveInfinity);
        return true;
    }

    void want_free_slot(std::uint32_t child) {
        alignas(16) static constexpr std::array<float, 8> sign_x = {1, 1, 1, 1, -1, -1, -1, -1};
        alignas(16) static constexpr std::array<float, 8> sign_y = {1, 1, -1, -1, 1, 1, -1, -1};
        alignas(16) static constexpr std::array<float, 8> sign_z = {1, -1, 1, -1, 1, -1, 1, -1};
        const auto costs_of = [&](std::uint32_t half) {
            const std::size_t begin = std::size_t{4} * half;
            const Float4 x = Float4::filled(x_[child]) * Float4::load(sign_x.data() + begin);
            const Float4 y = Float4::filled(y_[child]) * Float4::load(sign_y.data() + begin);
            const Float4 z = Float4::filled(z_[child]) * Float4::load(sign_z.data() + begin);
            return max((x + y) + z, taken_[half]);
        };
        const Float4 low = costs_of(0), high = costs_of(1);
        slots_[child] = first_least(low, high);
        raise(costs_, child, min(low, high).least());
    }

    /// Lanes 0 .. 3 are `low`, 4 .. 7 `high`; none is NaN.
    static std::uint32_t first_least(Float4 low, Float4 high) noexcept {
        const Float4 least = Float4::filled(min(low, high).least());
        const std::uint32_t bits = equal(low, least).bits() | equal(high, least).bits() << 4U;
        return static_cast<std::uint32_t>(std::countr_zero(bits));
    }

    std::array<std::uint8_t, 8> child_in_;
    std::array<std::uint32_t, 8> slots_;          ///< That each child wants.
    alignas(16) std::array<float, 8> x_, y_, z_;  ///< Of each child, from the node's centre, doubled.
    Floats8 costs_;                               ///< Of the slot for the child; infinite where it has got one.
    /// Infinite for slots that are taken, else minus infinite.
    Floats8 taken_ = {Float4::filled(kNegativeInfinity), Float4::filled(kNegativeInfinity)};
};

}  // namespace clbvh::layout
