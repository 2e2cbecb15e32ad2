#pragma once

#include <cstdint>
#include <filesystem>

#include "clbvh/export.h"
#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/layout_kind.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/layout/wide.hpp"

namespace clbvh {

/// Writes a layout to a temporary name beside `path` and renames it, so that `path` is never half-written.
///
/// Little-endian: a 64-byte header, then the nodes as they lie in memory, then the blocks, triangles or primitive ids.
///
/// | bytes | what |
/// |---|---|
/// | 0 .. 7 | char magic[8] = "CLBVHL\0\1"; the last is the version of the format |
/// | 8 .. 11 | uint32 LayoutKind |
/// | 12 .. 15 | uint32 bytes of a node |
/// | 16 .. 19 | uint32 bytes of a block, of a triangle or of an id |
/// | 20 .. 23 | uint32 depth |
/// | 24 .. 31 | uint64 number of nodes |
/// | 32 .. 39 | uint64 number of blocks, of triangles or of ids |
/// | 40 .. 47 | uint64 primitive_count |
/// | 48 .. 51 | uint32 flags: bit 0 is split_references, the others are zero |
/// | 52 .. 55 | uint32 zero |
/// | 56 .. 63 | uint64 xxh64, seed 0, of the 56 bytes above and all behind the header |
///
/// Throws Error(io) naming the path and the system's reason.
CLBVH_IO_API void write_layout(const Wide8& layout, const std::filesystem::path& path);
CLBVH_IO_API void write_layout(const Wide4& layout, const std::filesystem::path& path);
CLBVH_IO_API void write_layout(const Compressed8& layout, const std::filesystem::path& path);
CLBVH_IO_API void write_layout(const PairLayout& layout, const std::filesystem::path& path);
CLBVH_IO_API void write_layout(const SkipLayout& layout, const std::filesystem::path& path);

/// What the header of a layout's file says.
struct LayoutFileInfo {
    LayoutKind kind = LayoutKind::wide8;
    std::uint64_t node_count = 0;
    std::uint64_t element_count = 0;  ///< Blocks, triangles or primitive ids.
    std::uint64_t primitive_count = 0;
    std::uint32_t depth = 0;
    bool split_references = false;
    std::uint64_t file_bytes = 0;
};

/// Reads the header alone, and checks it against the file's size. Throws Error(io) that says what is wrong.
[[nodiscard]] CLBVH_IO_API LayoutFileInfo read_layout_info(const std::filesystem::path& path);

/// Whether the file begins as write_layout writes it, in any version. Throws Error(io) where it cannot be read.
[[nodiscard]] CLBVH_IO_API bool is_layout_file(const std::filesystem::path& path);

/// Reads what write_layout wrote of this kind. Checks magic, version, kind, sizes and hash, and takes no more memory
/// than the file is long. Throws Error(io) that says what is wrong, Error(out_of_memory); `result` is then as it was.
///
/// Where nodes and leaves lead to is not followed: a file that was damaged by chance is refused, one that was made to
/// do harm is not. validate() of the layout, over its mesh, is what makes a file from elsewhere safe to trace or to
/// refit.
CLBVH_IO_API void read_layout(const std::filesystem::path& path, Wide8& result);
CLBVH_IO_API void read_layout(const std::filesystem::path& path, Wide4& result);
CLBVH_IO_API void read_layout(const std::filesystem::path& path, Compressed8& result);
CLBVH_IO_API void read_layout(const std::filesystem::path& path, PairLayout& result);
CLBVH_IO_API void read_layout(const std::filesystem::path& path, SkipLayout& result);

/// read_layout<clbvh::Wide8>(path)
template <typename Layout>
[[nodiscard]] Layout read_layout(const std::filesystem::path& path) {
    Layout result;
    read_layout(path, result);
    return result;
}

}  // namespace clbvh
