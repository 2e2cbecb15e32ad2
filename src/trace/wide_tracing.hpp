#pragma once

#include <cstdint>

#include "clbvh/core/ray.hpp"
#include "trace/wide_tree.hpp"

// Tracing through a wide tree with vectors. Hits are the same bits with every instruction set, and the same as those
// that traverse() finds in the binary tree.
namespace clbvh::trace {

enum class InstructionSet : std::uint8_t { portable, sse2, avx2 };

/// The functions that one instruction set is compiled into.
struct WideTracing {
    Hit (*closest)(const WideTree& tree, const Ray& ray);
    bool (*any)(const WideTree& tree, const Ray& ray);
};

/// True where this processor, and this build of the library, has the instruction set.
[[nodiscard]] bool is_available(InstructionSet set) noexcept;

[[nodiscard]] InstructionSet best_instruction_set() noexcept;

/// The instruction set is available.
[[nodiscard]] WideTracing wide_tracing(InstructionSet set, TriangleTest test) noexcept;

}  // namespace clbvh::trace
