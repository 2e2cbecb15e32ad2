#pragma once

#include <cstdint>

#include "host/agglomerative/aac_problem.hpp"

namespace clbvh::host::aac {

/// Which vectors the clustering works with. All give the same tree.
enum class InstructionSet : std::uint8_t { scalar, sse2, avx2 };

/// True where this machine, and this build of the library, has it.
[[nodiscard]] bool is_available(InstructionSet set) noexcept;

/// The fastest one that is available.
[[nodiscard]] InstructionSet best_instruction_set() noexcept;

/// The clustering itself, compiled for one instruction set. Both work on one thread and spawn no tasks.
template <typename Code>
struct Clusterer {
    /// BuildTree over the positions begin .. end, on an empty stack. Leaves at most `most` clusters, or as many as f
    /// says where that is fewer; returns how many.
    std::uint32_t (*build_tree)(const Problem<Code>& problem, Stack& stack, std::uint32_t begin, std::uint32_t end,
                                std::uint32_t most) noexcept;
    /// What BuildTree does with the clusters of its two children, 0 .. middle and middle .. top, with their closest
    /// ones. Leaves at most `target` clusters; returns how many.
    std::uint32_t (*unite)(const Problem<Code>& problem, Stack& stack, std::uint32_t middle, std::uint32_t top,
                           std::uint32_t target) noexcept;
};

/// `set` is available. Code is std::uint32_t or std::uint64_t.
template <typename Code>
[[nodiscard]] Clusterer<Code> clusterer(InstructionSet set) noexcept;

}  // namespace clbvh::host::aac
