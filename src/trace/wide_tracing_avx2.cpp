// Tracing, compiled for AVX2.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "clbvh/trace/box_tests.hpp"
#include "core/simd/avx2.hpp"
#include "core/simd/prefetch.hpp"
#include "trace/leaf_triangles.hpp"
#include "trace/triangle_tests.hpp"
#include "trace/wide_tracing.hpp"

namespace clbvh::trace {
namespace {

#include "trace/wide_triangles.ipp"
// Written in terms of that.
#include "trace/wide_tracing.ipp"
// And in terms of both.
#include "trace/packet_tracing.ipp"
// What is written for AVX2 alone, in terms of all of these.
#include "trace/stream_rays.ipp"
// In terms of that, too.
#include "trace/stream_blocks.ipp"
// In terms of these too.
#include "trace/ray_stream.ipp"

}  // namespace

WideTracing wide_tracing_avx2(TriangleTest test) noexcept {
    return tracing_of<simd::avx2::Set, RayStream>(test);
}

}  // namespace clbvh::trace
