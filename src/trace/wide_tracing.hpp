#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "clbvh/core/ray.hpp"
#include "core/simd/dispatch.hpp"
#include "trace/wide_tree.hpp"

// Tracing through a wide tree with vectors. Hits are the same bits with every instruction set, and the same as those
// that traverse() finds in the binary tree.
namespace clbvh::trace {

/// The functions that one instruction set is compiled into.
struct WideTracing {
    Hit (*closest)(const WideTree& tree, const Ray& ray);
    bool (*any)(const WideTree& tree, const Ray& ray);
};

/// A child whose siblings go first, and where the ray enters it.
struct DeferredChild {
    float t;
    std::uint32_t child;
};

/// Throws Error(out_of_memory). For files that are compiled for one instruction set: what throws stays out of them.
[[nodiscard]] std::unique_ptr<DeferredChild[]> allocate_stack(std::size_t size);

/// The instruction set is available.
[[nodiscard]] WideTracing wide_tracing(simd::InstructionSet set, TriangleTest test) noexcept;

/// The same, compiled for AVX2 where the library is.
[[nodiscard]] WideTracing wide_tracing_avx2(TriangleTest test) noexcept;

}  // namespace clbvh::trace
