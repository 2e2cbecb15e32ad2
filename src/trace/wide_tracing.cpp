// Tracing for every processor, and the choice between it and that of wide_tracing_avx2.cpp.
#include "trace/wide_tracing.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "clbvh/trace/box_tests.hpp"
#include "core/memory_errors.hpp"
#include "core/simd/float4.hpp"
#include "core/simd/prefetch.hpp"
#include "core/simd/scalar.hpp"
#include "trace/leaf_triangles.hpp"
#include "trace/triangle_tests.hpp"

namespace clbvh::trace {
namespace {

#include "trace/wide_triangles.ipp"
// Written in terms of that.
#include "trace/wide_tracing.ipp"
// And in terms of both.
#include "trace/packet_tracing.ipp"

}  // namespace

std::unique_ptr<std::uint64_t[]> allocate_stack(std::size_t size) {
    return with_memory_errors("the stack of a ray",
                              [&] { return std::make_unique_for_overwrite<std::uint64_t[]>(size); });
}

void add_hit(std::vector<Hit>& hits, const Hit& hit) {
    hits.push_back(hit);
}

WideTracing wide_tracing(simd::InstructionSet set, TriangleTest test) noexcept {
#if defined(CLBVH_HAS_AVX2)
    if (set == simd::InstructionSet::avx2) return wide_tracing_avx2(test);
#endif
    if (set == simd::InstructionSet::scalar) return tracing_of<simd::scalar::Set>(test);
    return tracing_of<simd::baseline::Set>(test);
}

}  // namespace clbvh::trace
