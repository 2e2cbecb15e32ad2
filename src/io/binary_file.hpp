#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "io/input_file.hpp"

// What files of the library's own formats share: a header, and behind it arrays as they lie in memory, little-endian.
namespace clbvh::io {

using Bytes = std::span<const std::byte>;

/// Those of a vector, a span or another array.
template <typename Array>
[[nodiscard]] Bytes bytes_of(const Array& array) noexcept {
    return std::as_bytes(std::span(array.data(), array.size()));
}

/// xxHash64 of all parts together, seed 0: the same bytes have the same hash on every platform.
[[nodiscard]] std::uint64_t hash_bytes(std::initializer_list<Bytes> parts);

/// Writes the parts one behind the other, to a temporary name that is renamed at the end. Throws Error(io).
void write_parts(const std::filesystem::path& path, std::initializer_list<Bytes> parts);

/// How files of one kind begin.
struct BinaryFormat {
    std::array<char, 8> magic;  ///< The last is the version of the format.
    std::string_view name;      ///< "BVH file"
};

/// Bit of the flags of trees and layouts: Bvh::split_references. The others are zero.
inline constexpr std::uint32_t kSplitReferences = 1;

/// An array behind a header.
struct ArraySize {
    std::uint64_t count;
    std::uint64_t element_bytes;
    std::string_view elements;  ///< "nodes"
};

/// Reads one file and distrusts it. All failures are Error(io) that name the file and say what is wrong with it.
class BinaryReader {
public:
    BinaryReader(const std::filesystem::path& path, const BinaryFormat& format)
        : path_(path), file_(path), format_(format) {}

    /// `Header` begins with the magic, which is checked, with its version.
    template <typename Header>
    [[nodiscard]] Header read_header() {
        static_assert(std::is_trivially_copyable_v<Header> && offsetof(Header, magic) == 0);
        Header header{};
        read_header(&header, sizeof header);
        return header;
    }

    /// Proves that these arrays, and nothing else, follow the header, so that there is no more to allocate for them
    /// than the file is long.
    void check_arrays(std::initializer_list<ArraySize> arrays) const;
    /// Proves that elements have the size that the library knows.
    void check_element(const ArraySize& array, std::uint64_t stated_bytes) const;
    void check_primitive_count(std::uint64_t count) const;

    template <typename Array>
    void read(Array& to) {
        static_assert(std::is_trivially_copyable_v<std::remove_reference_t<decltype(*to.data())>>);
        file_.read(to.data(), to.size() * sizeof *to.data());
    }

    void check_hash(std::uint64_t stated, std::uint64_t found) const;
    void check_flags(std::uint32_t flags) const;
    void check_reserved(std::uint64_t zero) const;

    [[nodiscard]] std::uint64_t file_bytes() const noexcept { return file_.size(); }
    [[noreturn]] void fail(const std::string& what) const;

private:
    void read_header(void* header, std::size_t bytes);

    std::filesystem::path path_;
    InputFile file_;
    BinaryFormat format_;
    std::size_t header_bytes_ = 0;
};

}  // namespace clbvh::io
