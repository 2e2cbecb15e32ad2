// The tracing of wide_tracing.ipp, compiled for several instruction sets, and the choice between them.
#include "trace/wide_tracing.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <type_traits>

#include "clbvh/trace/box_tests.hpp"
#include "clbvh/trace/traverse.hpp"
#include "core/memory_errors.hpp"
#include "trace/triangle_tests.hpp"

#if defined(CLBVH_TRACE_HAS_SSE2) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define CLBVH_TRACE_HAS_AVX2 1
#include <immintrin.h>
#endif

namespace clbvh::trace {
namespace {

/// A child whose siblings go first, and where the ray enters it.
struct DeferredChild {
    float t;
    std::uint32_t child;
};

/// Room for all children that one ray can defer: on the stack, or on the heap for trees of an unusual depth.
class WideStack {
public:
    explicit WideStack(std::uint32_t depth) {
        const std::size_t most = std::size_t{depth} * (kWideChildren - 1) + 1;
        if (most <= few_.size()) return;
        many_ = with_memory_errors("the stack of a ray",
                                   [&] { return std::make_unique_for_overwrite<DeferredChild[]>(most); });
        entries_ = many_.get();
    }
    [[nodiscard]] DeferredChild* entries() noexcept { return entries_; }

private:
    std::array<DeferredChild, 512> few_;
    std::unique_ptr<DeferredChild[]> many_;
    DeferredChild* entries_ = few_.data();
};

/// Asks for all of a node or block that will be visited, unless it gets out of the ray's reach until then.
inline void prefetch([[maybe_unused]] const WideTree& tree, [[maybe_unused]] std::uint32_t child) noexcept {
#if defined(__GNUC__)
    constexpr std::size_t line = 64;
    const bool is_leaf = (child & kLeafFlag) != 0;
    const auto* const begin = is_leaf ? reinterpret_cast<const char*>(&tree.blocks[child & ~kLeafFlag])
                                      : reinterpret_cast<const char*>(&tree.nodes[child]);
    const std::size_t bytes = is_leaf ? sizeof(TriangleBlock) : sizeof(WideNode);
    for (std::size_t offset = 0; offset < bytes; offset += line)
        __builtin_prefetch(begin + offset);
#endif
}

namespace portable {
#define CLBVH_TRACE_LANES 1
#include "trace/wide_lanes.ipp"
// Written in terms of the lanes.
#include "trace/wide_triangles.ipp"
// Written in terms of both.
#include "trace/wide_tracing.ipp"
#undef CLBVH_TRACE_LANES
}  // namespace portable

#if defined(CLBVH_TRACE_HAS_SSE2)
namespace sse2 {
#define CLBVH_TRACE_LANES 4
#include "trace/wide_lanes.ipp"
// Written in terms of the lanes.
#include "trace/wide_triangles.ipp"
// Written in terms of both.
#include "trace/wide_tracing.ipp"
#undef CLBVH_TRACE_LANES
}  // namespace sse2
#endif

#if defined(CLBVH_TRACE_HAS_AVX2)
// Everything between is compiled for AVX2 and is in a namespace of its own, so no other code can come to use it.
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,lzcnt")
namespace avx2 {
#define CLBVH_TRACE_LANES 8
#include "trace/wide_lanes.ipp"
// Written in terms of the lanes.
#include "trace/wide_triangles.ipp"
// Written in terms of both.
#include "trace/wide_tracing.ipp"
#undef CLBVH_TRACE_LANES
}  // namespace avx2
#pragma GCC pop_options
#endif

}  // namespace

bool is_available(InstructionSet set) noexcept {
#if defined(CLBVH_TRACE_HAS_AVX2)
    if (set == InstructionSet::avx2) {
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
               __builtin_cpu_supports("lzcnt");
    }
#endif
#if defined(CLBVH_TRACE_HAS_SSE2)
    if (set == InstructionSet::sse2) return true;
#endif
    return set == InstructionSet::portable;
}

InstructionSet best_instruction_set() noexcept {
    if (is_available(InstructionSet::avx2)) return InstructionSet::avx2;
    if (is_available(InstructionSet::sse2)) return InstructionSet::sse2;
    return InstructionSet::portable;
}

WideTracing wide_tracing([[maybe_unused]] InstructionSet set, TriangleTest test) noexcept {
#if defined(CLBVH_TRACE_HAS_AVX2)
    if (set == InstructionSet::avx2) return avx2::tracing(test);
#endif
#if defined(CLBVH_TRACE_HAS_SSE2)
    if (set == InstructionSet::sse2) return sse2::tracing(test);
#endif
    return portable::tracing(test);
}

}  // namespace clbvh::trace
