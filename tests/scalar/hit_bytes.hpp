#pragma once

#include <cstdint>
#include <vector>

namespace clbvh::test {

/// Hits and counts of rays of eight floats each (as Ray) on triangles of nine floats each, byte for byte.
/// hit_bytes.cpp is compiled twice: as it stands, and without vectors in namespace clbvh_scalar.
[[nodiscard]] std::vector<std::uint8_t> hit_bytes(const std::vector<float>& triangles, const std::vector<float>& rays);

}  // namespace clbvh::test
