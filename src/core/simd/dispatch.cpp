#include "core/simd/dispatch.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iterator>
#include <string>

#include "clbvh/core/error.hpp"
#include "core/simd/float4.hpp"

#if defined(CLBVH_HAS_AVX2)
#include <cpuid.h>
#endif

namespace clbvh::simd {
namespace {

/// True where the processor has all that files compiled for AVX2 may use (see src/CMakeLists.txt).
bool has_avx2() noexcept {
#if defined(CLBVH_HAS_AVX2)
    // clang 14 does not know lzcnt by its name.
    constexpr unsigned lzcnt = 1u << 5;
    unsigned a = 0, b = 0, c = 0, d = 0;
    const bool has_lzcnt = __get_cpuid(0x80000001u, &a, &b, &c, &d) != 0 && (c & lzcnt) != 0;
    return has_lzcnt && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
#else
    return false;
#endif
}

InstructionSet fastest() noexcept {
    return *std::find_if(std::rbegin(kInstructionSets), std::rend(kInstructionSets), is_available);
}

const char* environment() noexcept {
    const char* const name = std::getenv("CLBVH_SIMD");
    return name != nullptr && *name != '\0' ? name : nullptr;
}

/// The end of kInstructionSets where `name` is none of them.
const InstructionSet* find_named(std::string_view name) noexcept {
    return std::ranges::find(kInstructionSets, name, to_string);
}

InstructionSet initial() noexcept {
    const char* const name = environment();
    if (name == nullptr) return fastest();
    const InstructionSet* const named = find_named(name);
    return named != std::end(kInstructionSets) && is_available(*named) ? *named : fastest();
}

std::atomic<InstructionSet>& selected() noexcept {
    static std::atomic<InstructionSet> set = initial();
    return set;
}

std::string available_names() {
    std::string names;
    for (const InstructionSet set : kInstructionSets) {
        if (is_available(set)) names += (names.empty() ? "" : ", ") + std::string(to_string(set));
    }
    return names;
}

}  // namespace

std::string_view to_string(InstructionSet set) noexcept {
    switch (set) {
        case InstructionSet::scalar: return "scalar";
        case InstructionSet::sse2: return "sse2";
        case InstructionSet::neon: return "neon";
        case InstructionSet::avx2: return "avx2";
    }
    return "unknown";
}

bool is_available(InstructionSet set) noexcept {
    switch (set) {
        case InstructionSet::scalar:
#if defined(CLBVH_HAS_SSE2)
        case InstructionSet::sse2:
#endif
#if defined(CLBVH_HAS_NEON)
        case InstructionSet::neon:
#endif
            return true;
        case InstructionSet::avx2: {
            static const bool available = has_avx2();
            return available;
        }
        default: return false;
    }
}

InstructionSet instruction_set() noexcept {
    return selected().load(std::memory_order_relaxed);
}

void check_instruction_set() {
    const char* const name = environment();
    if (name == nullptr) return;
    const InstructionSet* const named = find_named(name);
    const bool exists = named != std::end(kInstructionSets);
    if (exists && is_available(*named)) return;
    throw Error(exists ? ErrorCode::unsupported : ErrorCode::invalid_input,
                "CLBVH_SIMD is " + std::string(name) + (exists ? ", which is not available here" : "") +
                    "; it must be one of " + available_names() + ", or empty");
}

void select_instruction_set(InstructionSet set) noexcept {
    selected().store(set, std::memory_order_relaxed);
}

}  // namespace clbvh::simd
