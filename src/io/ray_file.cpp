#include "clbvh/io/ray_file.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <bit>
#include <cstring>
#include <string>

#include "clbvh/core/error.hpp"
#include "io/input_file.hpp"
#include "io/output_file.hpp"

namespace clbvh {
namespace {

static_assert(std::endian::native == std::endian::little, "ray files are written as they lie in memory");

constexpr char kMagic[8] = {'C', 'L', 'R', 'A', 'Y', 'S', '\0', '\1'};

struct FileHeader {
    char magic[8];
    std::uint64_t count;
    std::uint32_t ray_bytes;
    std::uint32_t zero;
    std::uint64_t hash;
};
static_assert(sizeof(FileHeader) == 32);

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
    throw Error(ErrorCode::io, "cannot read " + path.string() + ": " + what);
}

/// The header, without the rays themselves. Nothing is allocated before the file's size confirms it.
void check_header(const FileHeader& header, std::uint64_t file_bytes, const std::filesystem::path& path) {
    if (std::memcmp(header.magic, kMagic, sizeof kMagic - 1) != 0) fail(path, "not a ray file: the magic is missing");
    if (header.magic[7] != kMagic[7]) {
        fail(path, "version " + std::to_string(static_cast<unsigned char>(header.magic[7])) +
                       " of the format; this library reads version 1");
    }
    if (header.ray_bytes != sizeof(Ray)) fail(path, "rays of " + std::to_string(header.ray_bytes) + " bytes, not 32");
    if (header.zero != 0) fail(path, "a reserved field of the header is not zero");
    const std::uint64_t payload = file_bytes - sizeof(FileHeader);
    if (payload % sizeof(Ray) != 0 || payload / sizeof(Ray) != header.count) {
        fail(path, "the header promises " + std::to_string(header.count) + " rays, but " + std::to_string(payload) +
                       " bytes follow it");
    }
}

}  // namespace

std::uint64_t hash_rays(std::span<const Ray> rays) {
    XXH64_state_t state;
    XXH64_reset(&state, 0);
    // xxHash takes no null pointer, which an empty span may hold.
    if (!rays.empty()) XXH64_update(&state, rays.data(), rays.size_bytes());
    return XXH64_digest(&state);
}

void write_rays(std::span<const Ray> rays, const std::filesystem::path& path) {
    FileHeader header{};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.count = rays.size();
    header.ray_bytes = sizeof(Ray);
    header.hash = hash_rays(rays);

    io::OutputFile file(path);
    file.write(&header, sizeof header);
    file.write(rays.data(), rays.size_bytes());
    file.commit();
}

std::vector<Ray> read_rays(const std::filesystem::path& path) {
    io::InputFile file(path);
    if (file.size() < sizeof(FileHeader)) fail(path, "too short for the header of a ray file");
    FileHeader header{};
    file.read(&header, sizeof header);
    check_header(header, file.size(), path);
    std::vector<Ray> rays(header.count);
    file.read(rays.data(), rays.size() * sizeof(Ray));
    if (hash_rays(rays) != header.hash) fail(path, "the hash does not match: the file is damaged");
    return rays;
}

}  // namespace clbvh
