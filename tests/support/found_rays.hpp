#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstddef>
#include <span>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/device/device_tracer.hpp"
#include "support/builders.hpp"

namespace clbvh::test {

/// Hits of rays, and their cost.
struct Found {
    std::vector<Hit> hits;
    std::vector<std::uint8_t> is_hit;
    std::vector<RayCounts> closest_counts, any_counts;

    explicit Found(std::size_t rays) : hits(rays), is_hit(rays), closest_counts(rays), any_counts(rays) {}
};

[[nodiscard]] Found found_by_host(const Bvh& bvh, const Mesh& mesh, TriangleTest test, std::span<const Ray> rays);

/// In the scene that was set. Also checks that nothing changes where nothing is counted.
[[nodiscard]] Found found_by_device(DeviceTracer& tracer, std::span<const Ray> rays);

/// Checks that both are the same: bit for bit where the device can do that, else but for the rays that run along edges.
void check_same(const Found& found, const Found& expected);

/// Rays of all kinds, `each` of every kind, invalid ones among them.
[[nodiscard]] std::vector<Ray> rays_for(const Mesh& mesh, std::size_t each = 100);

[[nodiscard]] DeviceTracerOptions tracer_options(Shape shape, TriangleTest test = TriangleTest::watertight);

/// Calls `check` with a tracer of each shape and test.
template <typename Check>
void for_each_tracer(Check check) {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const TriangleTest test : {TriangleTest::watertight, TriangleTest::moller_trumbore}) {
            INFO(to_string(shape) << ", test " << static_cast<int>(test));
            DeviceTracer tracer(shared_context(), tracer_options(shape, test));
            check(tracer);
        }
    }
}

/// How many elements differ in a bit.
template <typename T>
[[nodiscard]] std::size_t count_differences(const std::vector<T>& a, const std::vector<T>& b) {
    std::size_t differences = a.size() == b.size() ? 0 : 1;
    const auto bits = [](const T& value) { return std::bit_cast<std::array<std::byte, sizeof(T)>>(value); };
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        differences += bits(a[i]) != bits(b[i]) ? 1 : 0;
    return differences;
}

}  // namespace clbvh::test
