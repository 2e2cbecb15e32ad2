#pragma once

#include <catch2/catch.hpp>

#include "core/simd/dispatch.hpp"

namespace clbvh::test {

/// Calls `check` with each available instruction set selected, one after the other.
template <typename Check>
void with_each_instruction_set(const Check& check) {
    const simd::InstructionSet before = simd::instruction_set();
    for (const simd::InstructionSet set : simd::kInstructionSets) {
        if (!simd::is_available(set)) continue;
        INFO("instruction set " << simd::to_string(set));
        simd::select_instruction_set(set);
        check();
    }
    simd::select_instruction_set(before);
}

}  // namespace clbvh::test
