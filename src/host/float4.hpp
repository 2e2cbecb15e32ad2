#pragma once

#if defined(__SSE2__)
#include <emmintrin.h>
#else
#include <array>
#endif

#include <cstdint>

namespace clbvh::host {

/// Four floats that are worked on at once: three coordinates, and a fourth lane that does not matter.
/// SSE2 where the compiler has it (every x86-64), plain arrays elsewhere, with the same results.
struct Float4 {
#if defined(__SSE2__)
    __m128 lanes;

    [[nodiscard]] static Float4 load(const float* source) noexcept {
        return {_mm_loadu_ps(source)};
    }
    [[nodiscard]] static Float4 filled(float value) noexcept {
        return {_mm_set1_ps(value)};
    }
    [[nodiscard]] static Float4 of(float x, float y, float z) noexcept {
        return {_mm_setr_ps(x, y, z, 0.0f)};
    }
    void store(float* target) const noexcept {
        _mm_storeu_ps(target, lanes);
    }
    [[nodiscard]] float x() const noexcept {
        return _mm_cvtss_f32(lanes);
    }
    [[nodiscard]] float y() const noexcept {
        return _mm_cvtss_f32(_mm_shuffle_ps(lanes, lanes, 1));
    }
    [[nodiscard]] float z() const noexcept {
        return _mm_cvtss_f32(_mm_movehl_ps(lanes, lanes));
    }
    /// The same with 0 in the fourth lane, where bits of an integer may stand that would be slow to calculate with.
    [[nodiscard]] Float4 without_w() const noexcept {
        return {_mm_and_ps(lanes, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)))};
    }

    friend Float4 operator+(Float4 a, Float4 b) noexcept {
        return {_mm_add_ps(a.lanes, b.lanes)};
    }
    friend Float4 operator-(Float4 a, Float4 b) noexcept {
        return {_mm_sub_ps(a.lanes, b.lanes)};
    }
    friend Float4 operator*(Float4 a, Float4 b) noexcept {
        return {_mm_mul_ps(a.lanes, b.lanes)};
    }
    friend Float4 min(Float4 a, Float4 b) noexcept {
        return {_mm_min_ps(a.lanes, b.lanes)};
    }
    friend Float4 max(Float4 a, Float4 b) noexcept {
        return {_mm_max_ps(a.lanes, b.lanes)};
    }
    /// Each lane rounded towards zero.
    void truncate(std::int32_t* target) const noexcept {
        _mm_storeu_si128(reinterpret_cast<__m128i*>(target), _mm_cvttps_epi32(lanes));
    }
#else
    std::array<float, 4> lanes;

    [[nodiscard]] static Float4 load(const float* source) noexcept {
        return {{source[0], source[1], source[2], source[3]}};
    }
    [[nodiscard]] static Float4 filled(float value) noexcept {
        return {{value, value, value, value}};
    }
    [[nodiscard]] static Float4 of(float x, float y, float z) noexcept {
        return {{x, y, z, 0.0f}};
    }
    void store(float* target) const noexcept {
        for (std::size_t i = 0; i < 4; ++i)
            target[i] = lanes[i];
    }
    [[nodiscard]] float x() const noexcept {
        return lanes[0];
    }
    [[nodiscard]] float y() const noexcept {
        return lanes[1];
    }
    [[nodiscard]] float z() const noexcept {
        return lanes[2];
    }
    [[nodiscard]] Float4 without_w() const noexcept {
        return {{lanes[0], lanes[1], lanes[2], 0.0f}};
    }

    template <typename Operation>
    [[nodiscard]] static Float4 lane_by_lane(Float4 a, Float4 b, Operation operation) noexcept {
        Float4 result;
        for (std::size_t i = 0; i < 4; ++i)
            result.lanes[i] = operation(a.lanes[i], b.lanes[i]);
        return result;
    }
    friend Float4 operator+(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x + y; });
    }
    friend Float4 operator-(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x - y; });
    }
    friend Float4 operator*(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x * y; });
    }
    friend Float4 min(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x < y ? x : y; });
    }
    friend Float4 max(Float4 a, Float4 b) noexcept {
        return lane_by_lane(a, b, [](float x, float y) { return x > y ? x : y; });
    }
    void truncate(std::int32_t* target) const noexcept {
        for (std::size_t i = 0; i < 4; ++i)
            target[i] = static_cast<std::int32_t>(lanes[i]);
    }
#endif
};

/// half_area() of a box whose extents are in the first three lanes, with the same order of operations.
[[nodiscard]] inline float half_area_of_extents(Float4 extents) noexcept {
    const float x = extents.x();
    const float y = extents.y();
    const float z = extents.z();
    return x * (y + z) + y * z;
}

}  // namespace clbvh::host
