#pragma once

#include <cstdint>

#include "core/simd/dispatch.hpp"
#include "host/agglomerative/aac_problem.hpp"

namespace clbvh::host::aac {

/// The clustering itself, compiled for one instruction set. Both work on one thread and spawn no tasks.
struct Clusterer {
    /// BuildTree over the positions begin .. end, on an empty stack. Leaves at most `most` clusters, or as many as f
    /// says where that is fewer; returns how many.
    std::uint32_t (*build_tree)(const Problem& problem, Stack& stack, std::uint32_t begin, std::uint32_t end,
                                std::uint32_t most) noexcept;
    /// BuildTree's last step: unites the clusters of its two children, 0 .. middle and middle .. top, whose closest
    /// ones are known. Leaves at most `target` clusters; returns how many.
    std::uint32_t (*unite)(const Problem& problem, Stack& stack, std::uint32_t middle, std::uint32_t top,
                           std::uint32_t target) noexcept;
};

/// `set` is available.
[[nodiscard]] Clusterer clusterer(simd::InstructionSet set) noexcept;

/// The same, compiled for AVX2 where the library is.
[[nodiscard]] Clusterer clusterer_avx2() noexcept;

}  // namespace clbvh::host::aac
