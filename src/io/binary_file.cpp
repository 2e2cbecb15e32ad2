#include "io/binary_file.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <bit>

#include "clbvh/core/error.hpp"
#include "clbvh/core/mesh.hpp"
#include "io/output_file.hpp"

namespace clbvh::io {

static_assert(std::endian::native == std::endian::little, "files are written as their arrays lie in memory");

std::uint64_t hash_bytes(std::initializer_list<Bytes> parts) {
    XXH64_state_t state;
    XXH64_reset(&state, 0);
    for (const Bytes part : parts) {
        // xxHash takes no null pointer, which an empty span may hold.
        if (!part.empty()) XXH64_update(&state, part.data(), part.size());
    }
    return XXH64_digest(&state);
}

void write_parts(const std::filesystem::path& path, std::initializer_list<Bytes> parts) {
    OutputFile file(path);
    for (const Bytes part : parts)
        file.write(part.data(), part.size());
    file.commit();
}

void BinaryReader::read_header(void* header, std::size_t bytes) {
    const std::string name(format_.name);
    if (file_.size() < bytes) fail("too short for the header of a " + name);
    file_.read(header, bytes);
    header_bytes_ = bytes;
    const char* const magic = static_cast<const char*>(header);
    if (!std::equal(format_.magic.begin(), format_.magic.end() - 1, magic))
        fail("not a " + name + ": the magic is missing");
    if (magic[7] != format_.magic[7]) {
        fail("version " + std::to_string(static_cast<unsigned char>(magic[7])) +
             " of the format; this library reads version " + std::to_string(format_.magic[7]));
    }
}

void BinaryReader::check_arrays(std::initializer_list<ArraySize> arrays) const {
    const std::uint64_t payload = file_.size() - header_bytes_;
    std::uint64_t rest = payload;
    bool fits = true;
    std::string promised;
    for (const ArraySize& array : arrays) {
        // No product overflows where this holds.
        fits = fits && array.count <= rest / array.element_bytes;
        if (fits) rest -= array.count * array.element_bytes;
        promised += (promised.empty() ? "" : " and ") + std::to_string(array.count) + " " + std::string(array.elements);
    }
    if (fits && rest == 0) return;
    fail("the header promises " + promised + ", but " + std::to_string(payload) + " bytes follow it");
}

void BinaryReader::check_element(const ArraySize& array, std::uint64_t stated_bytes) const {
    if (stated_bytes == array.element_bytes) return;
    fail(std::string(array.elements) + " of " + std::to_string(stated_bytes) + " bytes, not " +
         std::to_string(array.element_bytes));
}

void BinaryReader::check_primitive_count(std::uint64_t count) const {
    if (count > kMaxPrimitives)
        fail(std::to_string(count) + " primitives, more than the limit of " + std::to_string(kMaxPrimitives));
}

void BinaryReader::check_hash(std::uint64_t stated, std::uint64_t found) const {
    if (stated != found) fail("the hash does not match: the file is damaged");
}

void BinaryReader::check_flags(std::uint32_t flags) const {
    if ((flags & ~kSplitReferences) != 0) fail("unknown flags " + std::to_string(flags));
}

void BinaryReader::check_reserved(std::uint64_t zero) const {
    if (zero != 0) fail("a reserved field of the header is not zero");
}

void BinaryReader::fail(const std::string& what) const {
    throw Error(ErrorCode::io, "cannot read " + path_.string() + ": " + what);
}

}  // namespace clbvh::io
