// Tests of two rays of a stream at a time, each against the four triangles of a block of its own, for AVX2: one ray
// fills half of a vector. In terms of wide_triangles.ipp and stream_rays.ipp.

/// A ray, and the block that it tests.
struct RayAtBlock {
    const StreamRay& ray;
    const TriangleBlock& block;
};

/// LaneHits of two rays, those of the first in the lower half.
struct PairHits {
    std::uint32_t sure, inexact;
    alignas(32) std::array<std::array<float, 2 * kBlockTriangles>, 4> values;  ///< t, scaled_u, scaled_v, scale.

    template <typename Floats8>
    void store(const LaneHits<Floats8>& hits) noexcept {
        sure = hits.sure;
        inexact = hits.inexact;
        hits.t.store_aligned(values[0].data());
        hits.scaled_u.store_aligned(values[1].data());
        hits.scaled_v.store_aligned(values[2].data());
        hits.scale.store_aligned(values[3].data());
    }
    /// Those of one ray: 0 or 1.
    template <typename Floats4>
    [[nodiscard]] LaneHits<Floats4> of(std::uint32_t which) const noexcept {
        const std::uint32_t first = which * kBlockTriangles;
        const auto value = [&](std::size_t i) { return Floats4::load_aligned(values[i].data() + std::size_t{first}); };
        return {sure >> first & kAllLanes<Floats4>,
                inexact >> first & kAllLanes<Floats4>,
                value(0),
                value(1),
                value(2),
                value(3)};
    }
};

template <typename Floats8>
[[nodiscard]] CLBVH_ALWAYS_INLINE std::array<Floats8, 3> axes_of(const Floats8& part) noexcept {
    return {part.template spread<0>(), part.template spread<1>(), part.template spread<2>()};
}

/// Finds the hits up to each ray's reach, without a branch. `rays` is the span that they are of.
template <typename Set, typename Test>
CLBVH_ALWAYS_INLINE void test_pair(const RayAtBlock& a, const RayAtBlock& b, std::span<const Ray> rays,
                                   PairHits& result) noexcept {
    using Floats4 = typename Set::Float4;
    using Floats8 = typename Set::Float8;
    const auto of_both = [&](std::array<float, 4> StreamRay::*part) {
        return Floats8::of_halves(Floats4::load_aligned((a.ray.*part).data()),
                                  Floats4::load_aligned((b.ray.*part).data()));
    };
    const auto coordinates = [&](std::size_t vertex, std::size_t axis_a, std::size_t axis_b) {
        return Floats8::of_halves(Floats4::load_aligned(a.block.vertices[vertex][axis_a].data()),
                                  Floats4::load_aligned(b.block.vertices[vertex][axis_b].data()));
    };
    const Floats8 factors = of_both(&StreamRay::factors);
    const Floats8 reach = factors.template spread<3>();
    if constexpr (std::is_same_v<Test, WatertightTest>) {
        const Floats8 origin = of_both(&StreamRay::sheared);
        const WatertightLanes<Floats8> lanes(axes_of(origin), axes_of(factors), origin.template spread<3>());
        const auto vertices = [&](std::size_t vertex, std::size_t axis) {
            return coordinates(vertex, a.ray.axes.shear[axis], b.ray.axes.shear[axis]);
        };
        result.store(lanes.hits_straight(vertices, reach));
    } else {
        const Floats8 origin = of_both(&StreamRay::origin);
        const Vec3 &d_a = rays[a.ray.number].direction, &d_b = rays[b.ray.number].direction;
        const auto filled = [](float low, float high) {
            return Floats8::of_halves(Floats4::filled(low), Floats4::filled(high));
        };
        const MollerTrumboreLanes<Floats8> lanes(axes_of(origin),
                                                 {filled(d_a.x, d_b.x), filled(d_a.y, d_b.y), filled(d_a.z, d_b.z)},
                                                 origin.template spread<3>());
        const auto vertices = [&](std::size_t vertex, std::size_t axis) { return coordinates(vertex, axis, axis); };
        result.store(lanes.hits_straight(vertices, reach));
    }
}
