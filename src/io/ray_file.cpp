#include "clbvh/io/ray_file.hpp"

#include "io/binary_file.hpp"

namespace clbvh {
namespace {

constexpr io::BinaryFormat kRayFormat = {{'C', 'L', 'R', 'A', 'Y', 'S', '\0', '\1'}, "ray file"};

struct RayFileHeader {
    std::array<char, 8> magic;
    std::uint64_t count;
    std::uint32_t ray_bytes;
    std::uint32_t zero;
    std::uint64_t hash;
};
static_assert(sizeof(RayFileHeader) == 32);

}  // namespace

std::uint64_t hash_rays(std::span<const Ray> rays) {
    return io::hash_bytes({std::as_bytes(rays)});
}

void write_rays(std::span<const Ray> rays, const std::filesystem::path& path) {
    RayFileHeader header{};
    header.magic = kRayFormat.magic;
    header.count = rays.size();
    header.ray_bytes = sizeof(Ray);
    header.hash = hash_rays(rays);
    io::write_parts(path, {io::bytes_of(std::span(&header, 1)), std::as_bytes(rays)});
}

std::vector<Ray> read_rays(const std::filesystem::path& path) {
    io::BinaryReader reader(path, kRayFormat);
    const auto header = reader.read_header<RayFileHeader>();
    const io::ArraySize size{header.count, sizeof(Ray), "rays"};
    reader.check_element(size, header.ray_bytes);
    reader.check_reserved(header.zero);
    reader.check_arrays({size});
    std::vector<Ray> rays(header.count);
    reader.read(rays);
    reader.check_hash(header.hash, hash_rays(rays));
    return rays;
}

}  // namespace clbvh
