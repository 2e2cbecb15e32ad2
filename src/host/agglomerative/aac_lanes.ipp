// Vectors of floats, as wide as the instruction set that aac_clustering.cpp includes this file for.
// All give the same bits. CLBVH_AAC_LANES: 1 (any machine), 4 (SSE2), 8 (AVX2).

#if CLBVH_AAC_LANES == 1

struct Floats {
    static constexpr std::uint32_t kCount = 1;
    float lane;

    static Floats load(const float* source) noexcept { return {*source}; }
    static Floats filled(float value) noexcept { return {value}; }
    static Floats index(std::uint32_t value) noexcept { return {std::bit_cast<float>(value)}; }
    void store(float* target) const noexcept { *target = lane; }
    /// Stores the first `count` lanes, at least one.
    void store_first(std::uint32_t, float* target) const noexcept { *target = lane; }
    [[nodiscard]] float least() const noexcept { return lane; }
};

struct Mask {
    bool lane;

    [[nodiscard]] std::uint32_t bits() const noexcept { return lane ? 1 : 0; }
};
inline Floats operator+(Floats a, Floats b) noexcept {
    return {a.lane + b.lane};
}
inline Floats operator-(Floats a, Floats b) noexcept {
    return {a.lane - b.lane};
}
inline Floats operator*(Floats a, Floats b) noexcept {
    return {a.lane * b.lane};
}
inline Floats min(Floats a, Floats b) noexcept {
    return {a.lane < b.lane ? a.lane : b.lane};
}
inline Floats max(Floats a, Floats b) noexcept {
    return {a.lane > b.lane ? a.lane : b.lane};
}
inline Mask operator|(Mask a, Mask b) noexcept {
    return {a.lane || b.lane};
}
inline Mask less(Floats a, Floats b) noexcept {
    return {a.lane < b.lane};
}
inline Mask equal(Floats a, Floats b) noexcept {
    return {a.lane == b.lane};
}
inline Mask same_index(Floats a, Floats b) noexcept {
    return {std::bit_cast<std::uint32_t>(a.lane) == std::bit_cast<std::uint32_t>(b.lane)};
}
inline Floats select(Mask mask, Floats a, Floats b) noexcept {
    return mask.lane ? a : b;
}
inline Mask first_lanes(std::uint32_t count) noexcept {
    return {count > 0};
}
inline Mask only_lane(std::uint32_t lane) noexcept {
    return {lane == 0};
}

#else

#if CLBVH_AAC_LANES == 4
#define CLBVH_AAC_SIMD(name) _mm_##name
using Register = __m128;
using Integers = __m128i;
#else
#define CLBVH_AAC_SIMD(name) _mm256_##name
using Register = __m256;
using Integers = __m256i;
#endif

struct Mask {
    Register lanes;

    [[nodiscard]] std::uint32_t bits() const noexcept {
        return static_cast<std::uint32_t>(CLBVH_AAC_SIMD(movemask_ps)(lanes));
    }
};

struct Floats {
    static constexpr std::uint32_t kCount = CLBVH_AAC_LANES;
    Register lanes;

    static Floats load(const float* source) noexcept { return {CLBVH_AAC_SIMD(loadu_ps)(source)}; }
    static Floats filled(float value) noexcept { return {CLBVH_AAC_SIMD(set1_ps)(value)}; }
    /// An index in each lane, to be moved and compared for equality only.
    static Floats index(std::uint32_t value) noexcept { return filled(std::bit_cast<float>(value)); }
    void store(float* target) const noexcept { CLBVH_AAC_SIMD(storeu_ps)(target, lanes); }
    /// Stores the first `count` lanes, at least one.
    void store_first(std::uint32_t count, float* target) const noexcept;
    [[nodiscard]] float least() const noexcept;
};

inline Mask operator|(Mask a, Mask b) noexcept {
    return {CLBVH_AAC_SIMD(or_ps)(a.lanes, b.lanes)};
}
inline Floats operator+(Floats a, Floats b) noexcept {
    return {CLBVH_AAC_SIMD(add_ps)(a.lanes, b.lanes)};
}
inline Floats operator-(Floats a, Floats b) noexcept {
    return {CLBVH_AAC_SIMD(sub_ps)(a.lanes, b.lanes)};
}
inline Floats operator*(Floats a, Floats b) noexcept {
    return {CLBVH_AAC_SIMD(mul_ps)(a.lanes, b.lanes)};
}
inline Floats min(Floats a, Floats b) noexcept {
    return {CLBVH_AAC_SIMD(min_ps)(a.lanes, b.lanes)};
}
inline Floats max(Floats a, Floats b) noexcept {
    return {CLBVH_AAC_SIMD(max_ps)(a.lanes, b.lanes)};
}

/// Lanes below `count` begin at entry 8 - count.
alignas(32) constexpr std::int32_t kFirstLanes[16] = {-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0};

inline Mask first_lanes(std::uint32_t count) noexcept {
    const std::uint32_t inside = count < Floats::kCount ? count : Floats::kCount;
    return {Floats::load(reinterpret_cast<const float*>(kFirstLanes + 8 - inside)).lanes};
}

#if CLBVH_AAC_LANES == 4
inline Mask less(Floats a, Floats b) noexcept {
    return {_mm_cmplt_ps(a.lanes, b.lanes)};
}
inline Mask equal(Floats a, Floats b) noexcept {
    return {_mm_cmpeq_ps(a.lanes, b.lanes)};
}
inline Mask same_index(Floats a, Floats b) noexcept {
    return {_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_castps_si128(a.lanes), _mm_castps_si128(b.lanes)))};
}
inline Floats select(Mask mask, Floats a, Floats b) noexcept {
    return {_mm_or_ps(_mm_and_ps(mask.lanes, a.lanes), _mm_andnot_ps(mask.lanes, b.lanes))};
}
inline Mask only_lane(std::uint32_t lane) noexcept {
    return {_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(static_cast<int>(lane))))};
}
inline float Floats::least() const noexcept {
    const __m128 twos = _mm_min_ps(lanes, _mm_movehl_ps(lanes, lanes));
    return _mm_cvtss_f32(_mm_min_ss(twos, _mm_shuffle_ps(twos, twos, 1)));
}
inline void Floats::store_first(std::uint32_t count, float* target) const noexcept {
    select(first_lanes(count), *this, load(target)).store(target);
}
#else
inline Mask less(Floats a, Floats b) noexcept {
    return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_LT_OQ)};
}
inline Mask equal(Floats a, Floats b) noexcept {
    return {_mm256_cmp_ps(a.lanes, b.lanes, _CMP_EQ_OQ)};
}
inline Mask same_index(Floats a, Floats b) noexcept {
    return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_castps_si256(a.lanes), _mm256_castps_si256(b.lanes)))};
}
inline Floats select(Mask mask, Floats a, Floats b) noexcept {
    return {_mm256_blendv_ps(b.lanes, a.lanes, mask.lanes)};
}
inline Mask only_lane(std::uint32_t lane) noexcept {
    return {_mm256_castsi256_ps(
        _mm256_cmpeq_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_epi32(static_cast<int>(lane))))};
}
inline float Floats::least() const noexcept {
    const __m128 fours = _mm_min_ps(_mm256_castps256_ps128(lanes), _mm256_extractf128_ps(lanes, 1));
    const __m128 twos = _mm_min_ps(fours, _mm_movehl_ps(fours, fours));
    return _mm_cvtss_f32(_mm_min_ss(twos, _mm_shuffle_ps(twos, twos, 1)));
}
inline void Floats::store_first(std::uint32_t count, float* target) const noexcept {
    _mm256_maskstore_ps(target, _mm256_castps_si256(first_lanes(count).lanes), lanes);
}
#endif

#undef CLBVH_AAC_SIMD
#endif
