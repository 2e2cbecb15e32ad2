#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "clbvh/core/ray.hpp"
#include "clbvh/export.h"

namespace clbvh {

/// xxHash64 of the rays as they lie in memory, seed 0: the same rays have the same hash on every platform.
[[nodiscard]] CLBVH_IO_API std::uint64_t hash_rays(std::span<const Ray> rays);

/// Writes `rays` to a temporary name beside `path` and renames it, so that `path` is never half-written.
///
/// Little-endian: a 32-byte header {char magic[8] = "CLRAYS\0\1"; uint64 count; uint32 ray_bytes = 32; uint32 zero;
/// uint64 hash_rays() of the rays}, then the rays: float origin[3], t_min, direction[3], t_max. Throws Error(io) naming
/// the path and the system's reason.
CLBVH_IO_API void write_rays(std::span<const Ray> rays, const std::filesystem::path& path);

/// Reads what write_rays wrote. Checks magic, size and hash. Throws Error(io) that says what is wrong.
[[nodiscard]] CLBVH_IO_API std::vector<Ray> read_rays(const std::filesystem::path& path);

}  // namespace clbvh
