// The vectors of this processor give the bits that those without any instructions give, operation by operation.
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/simd/float4.hpp"
#include "core/simd/scalar.hpp"

using namespace clbvh;

namespace {

using Lanes = std::array<std::uint32_t, 4>;

/// Values where instruction sets could differ.
std::vector<float> hard_values() {
    using Limits = std::numeric_limits<float>;
    std::vector<float> values{0.0f,
                              1.0f,
                              1.5f,
                              3.0f,
                              0.1f,
                              1e-20f,
                              1e20f,
                              Limits::min(),
                              Limits::max(),
                              Limits::denorm_min(),
                              Limits::infinity(),
                              Limits::epsilon(),
                              16777217.0f,
                              0x1.fffffep30f};
    for (std::size_t i = values.size(); i-- > 0;)
        values.push_back(-values[i]);
    values.push_back(Limits::quiet_NaN());
    return values;
}

/// All of them against all, four pairs at a time, each pair in each lane.
template <typename Check>
void for_all_pairs(const Check& check) {
    const std::vector<float> values = hard_values();
    const std::size_t count = values.size();
    for (std::size_t shift = 0; shift < count; ++shift) {
        for (std::size_t first = 0; first < count; ++first) {
            std::array<float, 4> a, b;
            for (std::size_t lane = 0; lane < 4; ++lane) {
                a[lane] = values[(first + lane) % count];
                b[lane] = values[(first + lane * 5 + shift) % count];
            }
            check(a, b);
        }
    }
}

template <typename Vector>
Lanes bits_of(const Vector& vector) {
    Lanes bits;
    vector.store(reinterpret_cast<float*>(bits.data()));
    for (std::uint32_t& lane : bits) {
        // Which NaN it is differs between processors, and nothing depends on it.
        if (std::isnan(std::bit_cast<float>(lane))) lane = 0x7fc00000u;
    }
    return bits;
}

/// What all operations give on a and b.
template <typename Vector>
std::vector<Lanes> results(const std::array<float, 4>& a_lanes, const std::array<float, 4>& b_lanes) {
    const Vector a = Vector::load(a_lanes.data()), b = Vector::load(b_lanes.data());
    const Vector filled = Vector::filled(a_lanes[2]), point = Vector::of(a_lanes[0], b_lanes[1], a_lanes[3]);
    std::vector<Lanes> all{bits_of(a + b),
                           bits_of(a - b),
                           bits_of(a * b),
                           bits_of(a / b),
                           bits_of(min(a, b)),
                           bits_of(max(a, b)),
                           bits_of(a.negated()),
                           bits_of(a.without_w()),
                           bits_of(a.with_w(0x12345678u)),
                           bits_of(filled),
                           bits_of(Vector::filled_with_bits(0x12345678u)),
                           bits_of(point),
                           bits_of(select(less(a, b), a, b)),
                           bits_of(Vector::of(a.x(), a.y(), a.z()))};
    all.push_back({less(a, b).bits(), less_equal(a, b).bits(), equal(a, b).bits(), same_bits(a, b).bits()});
    all.push_back({(less(a, b) | equal(a, filled)).bits(), 0, 0, 0});
    for (const std::uint32_t number : {0u, 1u, 2u, 3u, 4u, 5u, 0xffffffffu})
        all.push_back({Vector::first_lanes(number).bits(), Vector::only_lane(number).bits(), 0, 0});
    for (const std::uint32_t count : {1u, 2u, 3u, 4u, 9u}) {
        std::array<float, 4> target = b_lanes;
        a.store_first(count, target.data());
        all.push_back(bits_of(Vector::load(target.data())));
    }
    Vector rows[4] = {a, b, filled, point};
    Vector::transpose(rows[0], rows[1], rows[2]);
    for (int i = 0; i < 3; ++i)
        all.push_back(bits_of(rows[i].without_w()));
    Vector square[4] = {a, b, filled, point};
    Vector::transpose(square[0], square[1], square[2], square[3]);
    for (const Vector& row : square)
        all.push_back(bits_of(row));
    return all;
}

template <typename Double2, typename Float4>
std::vector<double> double_results(const std::array<float, 4>& a_lanes, const std::array<float, 4>& b_lanes) {
    const Float4 a = Float4::load(a_lanes.data()), b = Float4::load(b_lanes.data());
    const Double2 x = Double2::of_x(a, b), y = Double2::of_y(a, b), z = Double2::of_z(a, b);
    std::vector<double> all(6);
    (x + y).store(all.data());
    (y - z).store(all.data() + 2);
    (z * x).store(all.data() + 4);
    return all;
}

}  // namespace

TEST_CASE("vectors give the bits of plain floats", "[simd]") {
    std::size_t differences = 0;
    for_all_pairs([&](const auto& a, const auto& b) {
        if (results<simd::baseline::Float4>(a, b) != results<simd::scalar::Float4>(a, b)) ++differences;
    });
    CHECK(differences == 0);
}

TEST_CASE("pairs of doubles are those of plain doubles", "[simd]") {
    std::size_t differences = 0;
    for_all_pairs([&](const auto& a, const auto& b) {
        const auto vectors = double_results<simd::baseline::Double2, simd::baseline::Float4>(a, b);
        const auto plain = double_results<simd::scalar::Double2, simd::scalar::Float4>(a, b);
        for (std::size_t i = 0; i < plain.size(); ++i) {
            const bool same = vectors[i] == plain[i] || (std::isnan(vectors[i]) && std::isnan(plain[i]));
            if (!same) ++differences;
        }
    });
    CHECK(differences == 0);
}

TEST_CASE("vectors round towards zero, and find the least", "[simd]") {
    const std::array<float, 4> values{1.9f, -1.9f, 0x1.fffffep30f, 0.0f};
    std::array<std::int32_t, 4> vectors, plain;
    simd::baseline::Float4::load(values.data()).truncate(vectors.data());
    simd::scalar::Float4::load(values.data()).truncate(plain.data());
    CHECK(vectors == plain);
    CHECK(vectors == std::array<std::int32_t, 4>{1, -1, 0x7fffff80, 0});
    CHECK(simd::baseline::Float4::load(values.data()).least() == -1.9f);
    CHECK(simd::scalar::Float4::load(values.data()).least() == -1.9f);
    const std::array<std::int32_t, 4> numbers{1, -7, 16777217, std::numeric_limits<std::int32_t>::max()};
    const auto sum = [&]<typename Int4>(Int4 first) {
        return bits_of((first + Int4::load(numbers.data())).to_float());
    };
    const std::array<std::int32_t, 4> others{5, 6, 2, -3};
    CHECK(sum(simd::baseline::Int4::load(others.data())) == sum(simd::scalar::Int4::load(others.data())));
}
