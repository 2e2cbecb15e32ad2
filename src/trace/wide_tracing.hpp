#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "clbvh/core/ray.hpp"
#include "clbvh/layout/wide.hpp"
#include "clbvh/trace/hit_filter.hpp"
#include "core/simd/dispatch.hpp"

// Tracing through a tree of eight children with vectors. Hits are the same bits with every instruction set, and the
// same as those that traverse() finds in the binary tree.
namespace clbvh::trace {

/// The functions that one instruction set is compiled into.
struct WideTracing {
    Hit (*closest)(const Wide8& tree, const Ray& ray);
    bool (*any)(const Wide8& tree, const Ray& ray);
    Hit (*closest_filtered)(const Wide8& tree, const Ray& ray, const HitFilter& filter);
    bool (*any_filtered)(const Wide8& tree, const Ray& ray, const HitFilter& filter);
    /// Every hit, in no order; one primitive may come more than once.
    void (*all)(const Wide8& tree, const Ray& ray, std::vector<Hit>& hits);
    /// Many rays, those that lie close together as one, and with AVX2 others as a stream; results[i] is that of
    /// rays[i].
    void (*closest_of_many)(const Wide8& tree, std::span<const Ray> rays, Hit* results);
    void (*any_of_many)(const Wide8& tree, std::span<const Ray> rays, std::uint8_t* results);
};

// For files that are compiled for one instruction set: what may throw stays out of them.
/// Throws Error(out_of_memory).
[[nodiscard]] std::unique_ptr<std::uint64_t[]> allocate_stack(std::size_t size);
void add_hit(std::vector<Hit>& hits, const Hit& hit);

/// The instruction set is available.
[[nodiscard]] WideTracing wide_tracing(simd::InstructionSet set, TriangleTest test) noexcept;

/// The same, compiled for AVX2 where the library is.
[[nodiscard]] WideTracing wide_tracing_avx2(TriangleTest test) noexcept;

}  // namespace clbvh::trace
