// The rays of a stream (ray_stream.ipp), and how eight of them at a time are made ready, for AVX2.

/// What the signs of a ray's direction and its largest component decide.
struct StreamAxes {
    std::array<std::uint32_t, 3> near, far;  ///< Where a node has the sides through which the ray enters and leaves.
    std::array<std::uint32_t, 3> shear;      ///< The axes that become x, y and z, see WatertightTest.
};

/// A ray under way, in two cache lines.
struct alignas(64) StreamRay {
    alignas(16) std::array<float, 4> origin;   ///< Then t_min, at least 0.
    alignas(16) std::array<float, 4> inverse;  ///< Of the direction; then the ray's own t_max.
    alignas(16) std::array<float, 4> sheared;  ///< The origin along axes.shear; then t_min, too.
    alignas(16) std::array<float, 4> factors;  ///< Of WatertightTest; then up to where a box matters.
    StreamAxes axes;
    std::uint32_t child;   ///< What it visits next, see WideChild.
    std::uint32_t top;     ///< Of its stack: what it visits then stands below.
    std::uint32_t number;  ///< In the span.
    Hit hit;

    [[nodiscard]] const float& t_min() const noexcept { return origin[3]; }
    [[nodiscard]] float& reach() noexcept { return factors[3]; }
    [[nodiscard]] const float& reach() const noexcept { return factors[3]; }
    [[nodiscard]] const float& t_max() const noexcept { return inverse[3]; }
};

/// Of each octant (bit i: the direction is negative along axis i), times three, and the largest component.
inline constexpr std::array<StreamAxes, 24> kStreamAxes = [] {
    constexpr std::uint32_t axis_bytes = sizeof(WideNode<8>::bounds[0][0]), side_bytes = 3 * axis_bytes;
    std::array<StreamAxes, 24> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
        const std::uint32_t octant = i / 3, z = i % 3, x = (z + 1) % 3, y = (z + 2) % 3;
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const std::uint32_t side = octant >> axis & 1U;
            table[i].near[axis] = axis * axis_bytes + side * side_bytes;
            table[i].far[axis] = axis * axis_bytes + (1 - side) * side_bytes;
        }
        const bool swaps = (octant >> z & 1U) != 0;
        table[i].shear = {swaps ? y : x, swaps ? x : y, z};
    }
    return table;
}();

/// HitRule's side of a ray, in every lane.
template <typename Floats>
class StreamRayInAllLanes {
public:
    explicit StreamRayInAllLanes(const StreamRay& ray) noexcept : ray_(ray) {}

    [[nodiscard]] Floats begin() const noexcept { return Floats::filled(ray_.t_min()); }
    [[nodiscard]] Floats end() const noexcept { return Floats::filled(ray_.t_max()); }
    [[nodiscard]] Floats origin_of(unsigned axis) const noexcept { return Floats::filled(ray_.origin[axis]); }
    [[nodiscard]] Floats inverse_of(unsigned axis) const noexcept { return Floats::filled(ray_.inverse[axis]); }

private:
    const StreamRay& ray_;
};

/// Gives each of eight rays its part of four vectors.
template <typename Floats8>
void store_parts(const std::array<Floats8, 3>& axes, Floats8 last, std::array<float, 4> StreamRay::*part,
                 std::array<StreamRay, kPacketRays>& rays) noexcept {
    const auto store = [&](auto a, auto b, auto c, auto d, std::size_t first) {
        decltype(a)::transpose(a, b, c, d);
        a.store_aligned((rays[first].*part).data());
        b.store_aligned((rays[first + 1].*part).data());
        c.store_aligned((rays[first + 2].*part).data());
        d.store_aligned((rays[first + 3].*part).data());
    };
    store(axes[0].low_half(), axes[1].low_half(), axes[2].low_half(), last.low_half(), 0);
    store(axes[0].high_half(), axes[1].high_half(), axes[2].high_half(), last.high_half(), 4);
}

/// Which rays are traceable: one bit each. The arithmetic of all eight is that of one alone.
template <typename Floats8>
[[nodiscard]] std::uint32_t make_ready(const PacketRays<Floats8>& loaded, std::size_t first_number,
                                       std::array<StreamRay, kPacketRays>& rays) noexcept {
    const Floats8 zero = Floats8::filled(0.0f);
    const std::array<Floats8, 3>& d = loaded.direction;
    Floats8 nothing = zero;  // NaN where anything is infinite or NaN
    std::array<Floats8, 3> sizes;
    std::array<std::uint32_t, 3> negative;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        nothing = nothing + (loaded.origin[axis] - loaded.origin[axis]) + (d[axis] - d[axis]);
        sizes[axis] = max(d[axis], zero - d[axis]);
        negative[axis] = less(loaded.inverse[axis], zero).bits();
    }
    const Floats8 largest_of_xy = max(sizes[0], sizes[1]);
    const auto is_y = less(sizes[0], sizes[1]), is_z = less(largest_of_xy, sizes[2]);
    const auto by_largest = [&](Floats8 x, Floats8 y, Floats8 z) { return select(is_z, z, select(is_y, y, x)); };
    const Floats8 d_z = by_largest(d[0], d[1], d[2]);
    const Floats8 d_next = by_largest(d[1], d[2], d[0]), d_last = by_largest(d[2], d[0], d[1]);
    const auto swaps = less(d_z, zero);
    const std::array<Floats8, 3> factors{select(swaps, d_last, d_next) / d_z, select(swaps, d_next, d_last) / d_z,
                                         by_largest(loaded.inverse[0], loaded.inverse[1], loaded.inverse[2])};
    const std::array<Floats8, 3>& o = loaded.origin;
    const Floats8 o_next = by_largest(o[1], o[2], o[0]), o_last = by_largest(o[2], o[0], o[1]);
    const std::array<Floats8, 3> sheared{select(swaps, o_last, o_next), select(swaps, o_next, o_last),
                                         by_largest(o[0], o[1], o[2])};
    const Floats8 t_min = max(loaded.t_min, zero);
    store_parts(loaded.origin, t_min, &StreamRay::origin, rays);
    store_parts(sheared, t_min, &StreamRay::sheared, rays);
    store_parts(loaded.inverse, loaded.t_max, &StreamRay::inverse, rays);
    store_parts(factors, loaded.t_max, &StreamRay::factors, rays);
    for (std::uint32_t i = 0; i < kPacketRays; ++i) {
        const std::uint32_t octant =
            (negative[0] >> i & 1U) | (negative[1] >> i & 1U) << 1U | (negative[2] >> i & 1U) << 2U;
        const std::uint32_t largest = (is_z.bits() >> i & 1U) != 0 ? 2 : is_y.bits() >> i & 1U;
        rays[i].axes = kStreamAxes[3 * octant + largest];
        rays[i].child = 0;
        rays[i].number = static_cast<std::uint32_t>(first_number) + i;
        rays[i].hit = Hit{};
    }
    return equal(nothing, zero).bits() & less_equal(loaded.t_min, loaded.t_max).bits() &
           less(zero, max(largest_of_xy, sizes[2])).bits();
}
