#pragma once

#include <cstdint>
#include <string_view>

namespace clbvh::simd {

/// Which vectors the library works with. All give the same trees and hits, to the bit; later ones are faster.
enum class InstructionSet : std::uint8_t { scalar, sse2, neon, avx2 };

inline constexpr InstructionSet kInstructionSets[] = {InstructionSet::scalar, InstructionSet::sse2,
                                                      InstructionSet::neon, InstructionSet::avx2};

/// As CLBVH_SIMD names it, for example "avx2".
[[nodiscard]] std::string_view to_string(InstructionSet set) noexcept;

/// True where this processor, and this build of the library, has it.
[[nodiscard]] bool is_available(InstructionSet set) noexcept;

/// The one to work with: what select_instruction_set() was told last, else what the environment variable CLBVH_SIMD
/// names, else the fastest that is available.
[[nodiscard]] InstructionSet instruction_set() noexcept;

/// Throws Error(invalid_input) where CLBVH_SIMD names no instruction set, Error(unsupported) where it names one that is
/// not available; instruction_set() passes over both. Whatever dispatches calls it once, before any work.
void check_instruction_set();

/// Works with `set`, which is available, from now on. For tests: builds and tracers that are at work may use either.
void select_instruction_set(InstructionSet set) noexcept;

}  // namespace clbvh::simd
