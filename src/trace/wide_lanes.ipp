// Vectors of four and of eight floats, from the instruction set that wide_tracing.cpp includes this file for.
// All give the same bits. CLBVH_TRACE_LANES: 1 (any machine), 4 (SSE2), 8 (AVX2).

#if CLBVH_TRACE_LANES == 1

template <std::uint32_t Count>
struct Floats {
    std::array<float, Count> lanes;

    static Floats load(const float* source) noexcept {
        Floats loaded;
        std::copy_n(source, Count, loaded.lanes.begin());
        return loaded;
    }
    static Floats filled(float value) noexcept {
        Floats filled;
        filled.lanes.fill(value);
        return filled;
    }
    void store(float* target) const noexcept { std::ranges::copy(lanes, target); }
};

/// Makes an operator on lanes from one on floats.
template <std::uint32_t Count, typename Operation>
Floats<Count> for_lanes(const Floats<Count>& a, const Floats<Count>& b, Operation operation) noexcept {
    Floats<Count> result;
    for (std::uint32_t i = 0; i < Count; ++i)
        result.lanes[i] = operation(a.lanes[i], b.lanes[i]);
    return result;
}
/// One bit for each lane where the comparison holds.
template <std::uint32_t Count, typename Comparison>
std::uint32_t mask_of(const Floats<Count>& a, const Floats<Count>& b, Comparison comparison) noexcept {
    std::uint32_t mask = 0;
    for (std::uint32_t i = 0; i < Count; ++i)
        mask |= comparison(a.lanes[i], b.lanes[i]) ? 1U << i : 0U;
    return mask;
}

template <std::uint32_t Count>
Floats<Count> operator+(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return for_lanes(a, b, [](float x, float y) { return x + y; });
}
template <std::uint32_t Count>
Floats<Count> operator-(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return for_lanes(a, b, [](float x, float y) { return x - y; });
}
template <std::uint32_t Count>
Floats<Count> operator*(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return for_lanes(a, b, [](float x, float y) { return x * y; });
}
template <std::uint32_t Count>
Floats<Count> operator/(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return for_lanes(a, b, [](float x, float y) { return x / y; });
}
template <std::uint32_t Count>
Floats<Count> min(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return for_lanes(a, b, [](float x, float y) { return x < y ? x : y; });
}
template <std::uint32_t Count>
Floats<Count> max(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return for_lanes(a, b, [](float x, float y) { return x > y ? x : y; });
}
template <std::uint32_t Count>
std::uint32_t less(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return mask_of(a, b, [](float x, float y) { return x < y; });
}
template <std::uint32_t Count>
std::uint32_t less_equal(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return mask_of(a, b, [](float x, float y) { return x <= y; });
}
template <std::uint32_t Count>
std::uint32_t equal(const Floats<Count>& a, const Floats<Count>& b) noexcept {
    return mask_of(a, b, [](float x, float y) { return x == y; });
}

using Floats4 = Floats<4>;
using Floats8 = Floats<8>;

#else

/// min and max are their second operand where one is NaN; less, less_equal and equal have one bit for each lane.
struct Floats4 {
    __m128 lanes;

    static Floats4 load(const float* source) noexcept { return {_mm_load_ps(source)}; }
    static Floats4 filled(float value) noexcept { return {_mm_set1_ps(value)}; }
    void store(float* target) const noexcept { _mm_store_ps(target, lanes); }
};

inline Floats4 operator+(Floats4 a, Floats4 b) noexcept {
    return {_mm_add_ps(a.lanes, b.lanes)};
}
inline Floats4 operator-(Floats4 a, Floats4 b) noexcept {
    return {_mm_sub_ps(a.lanes, b.lanes)};
}
inline Floats4 operator*(Floats4 a, Floats4 b) noexcept {
    return {_mm_mul_ps(a.lanes, b.lanes)};
}
inline Floats4 operator/(Floats4 a, Floats4 b) noexcept {
    return {_mm_div_ps(a.lanes, b.lanes)};
}
inline Floats4 min(Floats4 a, Floats4 b) noexcept {
    return {_mm_min_ps(a.lanes, b.lanes)};
}
inline Floats4 max(Floats4 a, Floats4 b) noexcept {
    return {_mm_max_ps(a.lanes, b.lanes)};
}
inline std::uint32_t less(Floats4 a, Floats4 b) noexcept {
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmplt_ps(a.lanes, b.lanes)));
}
inline std::uint32_t less_equal(Floats4 a, Floats4 b) noexcept {
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmple_ps(a.lanes, b.lanes)));
}
inline std::uint32_t equal(Floats4 a, Floats4 b) noexcept {
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmpeq_ps(a.lanes, b.lanes)));
}

#if CLBVH_TRACE_LANES == 4

struct Floats8 {
    Floats4 low, high;

    static Floats8 load(const float* source) noexcept { return {Floats4::load(source), Floats4::load(source + 4)}; }
    static Floats8 filled(float value) noexcept { return {Floats4::filled(value), Floats4::filled(value)}; }
    void store(float* target) const noexcept {
        low.store(target);
        high.store(target + 4);
    }
};

inline Floats8 operator-(const Floats8& a, const Floats8& b) noexcept {
    return {a.low - b.low, a.high - b.high};
}
inline Floats8 operator*(const Floats8& a, const Floats8& b) noexcept {
    return {a.low * b.low, a.high * b.high};
}
inline Floats8 min(const Floats8& a, const Floats8& b) noexcept {
    return {min(a.low, b.low), min(a.high, b.high)};
}
inline Floats8 max(const Floats8& a, const Floats8& b) noexcept {
    return {max(a.low, b.low), max(a.high, b.high)};
}
inline std::uint32_t less_equal(const Floats8& a, const Floats8& b) noexcept {
    return less_equal(a.low, b.low) | less_equal(a.high, b.high) << 4;
}

#else

struct Floats8 {
    __m256 lanes;

    static Floats8 load(const float* source) noexcept { return {_mm256_load_ps(source)}; }
    static Floats8 filled(float value) noexcept { return {_mm256_set1_ps(value)}; }
    void store(float* target) const noexcept { _mm256_store_ps(target, lanes); }
};

inline Floats8 operator-(Floats8 a, Floats8 b) noexcept {
    return {_mm256_sub_ps(a.lanes, b.lanes)};
}
inline Floats8 operator*(Floats8 a, Floats8 b) noexcept {
    return {_mm256_mul_ps(a.lanes, b.lanes)};
}
inline Floats8 min(Floats8 a, Floats8 b) noexcept {
    return {_mm256_min_ps(a.lanes, b.lanes)};
}
inline Floats8 max(Floats8 a, Floats8 b) noexcept {
    return {_mm256_max_ps(a.lanes, b.lanes)};
}
inline std::uint32_t less_equal(Floats8 a, Floats8 b) noexcept {
    return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LE_OQ)));
}

#endif
#endif
