#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace clbvh::test {

/// The nodes and ids of the tree that host builder `id` builds, byte for byte, over triangles of nine floats each.
/// tree_bytes.cpp is compiled twice: as it stands, and without vectors in namespace clbvh_scalar.
[[nodiscard]] std::vector<std::uint8_t> tree_bytes(std::string_view id, const std::vector<float>& triangles);

}  // namespace clbvh::test
