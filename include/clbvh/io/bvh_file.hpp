#pragma once

#include <filesystem>

#include "clbvh/core/bvh.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// Writes `bvh` to a temporary name beside `path` and renames it, so that `path` is never half-written.
///
/// Little-endian: a 64-byte header {char magic[8] = "CLBVH\0\0\1"; uint64 node_count, id_count, primitive_count;
/// uint32 flags, node_bytes = 32; uint64 reserved = 0; uint64 xxh64 of the payload, seed 0; uint64 zero}, then the
/// nodes, then the uint32 primitive ids. Bit 0 of flags is Bvh::split_references; the others are zero. Throws Error(io)
/// naming the path and the system's reason.
CLBVH_IO_API void write_bvh(const Bvh& bvh, const std::filesystem::path& path);

/// Reads what write_bvh wrote. Checks magic, sizes, hash and every index before use.
/// Throws Error(io) that says what is wrong and where.
[[nodiscard]] CLBVH_IO_API Bvh read_bvh(const std::filesystem::path& path);

}  // namespace clbvh
