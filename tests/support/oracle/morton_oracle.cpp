#include "support/oracle/morton_oracle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "support/oracle/recode_oracle.hpp"

namespace clbvh::test {
namespace {

constexpr std::uint32_t kCodeBits = 63;
constexpr std::size_t kSizeChannel = 3;
constexpr std::size_t kNoChannel = 4;

/// Which channel each bit of a code comes from, the most significant first: an axis, or the primitive's size.
using BitSources = std::array<std::size_t, kCodeBits>;

std::array<float, 3> to_array(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Vec3 canonical(const Vec3& v) {
    return {v.x + 0.0f, v.y + 0.0f, v.z + 0.0f};
}

std::array<float, 3> extents_of(const Aabb& box) {
    return {box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z};
}

float diagonal(const Aabb& box) {
    const auto [x, y, z] = extents_of(box);
    return std::sqrt((x * x + y * y) + z * z);
}

BitSources xyz_sources() {
    BitSources sources{};
    for (std::size_t k = 0; k < sources.size(); ++k)
        sources[k] = k % 3;
    return sources;
}

/// Each bit halves the axis that is longest by then, of equal ones the first, until that has 30 bits. Bits that none
/// needs, and those behind the last whole round through all axes, come from the channel that is always 0.
BitSources cubic_sources(std::array<float, 3> extents) {
    BitSources sources{};
    sources.fill(kNoChannel);
    const std::size_t shortest =
        static_cast<std::size_t>(std::min_element(extents.rbegin(), extents.rend()).base() - 1 - extents.begin());
    std::array<int, 3> counts{};
    std::size_t rounds_begin = kCodeBits, length = 0;
    for (; length < kCodeBits; ++length) {
        const auto longest =
            static_cast<std::size_t>(std::max_element(extents.begin(), extents.end()) - extents.begin());
        if (counts[longest] == 30 || extents[longest] == 0.0f) break;
        if (longest == shortest) rounds_begin = std::min(rounds_begin, length);
        extents[longest] *= 0.5f;
        ++counts[longest];
        sources[length] = longest;
    }
    const std::size_t behind = length > rounds_begin ? (length - rounds_begin) % 3 : 0;
    std::fill(sources.begin() + static_cast<std::ptrdiff_t>(length - behind), sources.end(), kNoChannel);
    return sources;
}

/// Vinkler, Bittner, Havran 2017: each bit halves the axis that is longest by then; each seventh is one of the size.
BitSources extended_sources(std::array<float, 3> extents) {
    BitSources sources{};
    std::array<int, 3> counts{};
    for (std::size_t k = 0; k < sources.size(); ++k) {
        sources[k] = kSizeChannel;
        if (k % 7 == 6) continue;
        std::size_t longest = kSizeChannel;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (counts[axis] < 31 && (longest == kSizeChannel || extents[axis] > extents[longest])) longest = axis;
        }
        sources[k] = longest;
        extents[longest] *= 0.5f;
        ++counts[longest];
    }
    return sources;
}

/// `offset` within `extent`, as a number of `bits` bits.
std::uint32_t quantise(float offset, float extent, std::size_t bits) {
    if (!(extent > 0.0f)) return 0;
    const auto cells = static_cast<float>(1u << bits);
    const float scale = std::min(cells / extent, std::numeric_limits<float>::max());
    return std::min(static_cast<std::uint32_t>(offset * scale), (1u << bits) - 1);
}

std::uint32_t quantise_size(float size, float scene_size, std::size_t bits) {
    if (!(scene_size > 0.0f)) return 0;
    const float scale = static_cast<float>(1u << bits) / scene_size;
    return std::min(static_cast<std::uint32_t>(size * scale), (1u << bits) - 1);
}

/// Takes the bits of each channel, the most significant first, as `sources` asks for them.
std::uint64_t interleave(const BitSources& sources, const std::array<std::uint32_t, 5>& values,
                         std::array<std::size_t, 5> bits_left) {
    std::uint64_t code = 0;
    for (const std::size_t source : sources) {
        --bits_left[source];
        code = (code << 1) | (source == kNoChannel ? 0u : values[source] >> bits_left[source] & 1u);
    }
    return code;
}

}  // namespace

ActivePrimitives active_primitives(const Mesh& mesh) {
    ActivePrimitives active;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (is_inactive(mesh, i)) continue;
        const Aabb box = triangle_bounds(mesh, i);
        active.ids.push_back(static_cast<std::uint32_t>(i));
        active.bounds.push_back({canonical(box.lower), canonical(box.upper)});
    }
    return active;
}

SceneBounds scene_bounds(std::span<const Aabb> bounds) {
    SceneBounds scene;
    for (const Aabb& box : bounds) {
        scene.primitives = merge(scene.primitives, box);
        scene.doubled_centroids = merge(scene.doubled_centroids, doubled_centroid(box));
    }
    return scene;
}

std::vector<std::uint64_t> morton_codes(std::span<const Aabb> bounds, MortonCode code) {
    const SceneBounds scene = scene_bounds(bounds);
    const auto extents = extents_of(scene.doubled_centroids);
    const auto lower = to_array(scene.doubled_centroids.lower);
    const float scene_size = diagonal(scene.primitives);
    const BitSources sources = code == MortonCode::cubic ? cubic_sources(extents)
                               : code == MortonCode::xyz ? xyz_sources()
                                                         : extended_sources(extents);
    std::array<std::size_t, 5> bits{};
    for (const std::size_t source : sources)
        ++bits[source];

    std::vector<std::uint64_t> codes;
    for (const Aabb& box : bounds) {
        const auto centroid = to_array(doubled_centroid(box));
        std::array<std::uint32_t, 5> values{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            values[axis] = quantise(centroid[axis] - lower[axis], extents[axis], bits[axis]);
        }
        values[kSizeChannel] = quantise_size(diagonal(box), scene_size, bits[kSizeChannel]);
        codes.push_back(interleave(sources, values, bits));
    }
    return codes;
}

std::vector<std::uint64_t> packed_keys(std::span<const std::uint64_t> codes, std::span<const std::uint32_t> ids,
                                       std::uint64_t count, std::uint32_t code_bits) {
    std::uint32_t id_bits = 0;
    while (std::uint64_t{1} << id_bits < count)
        ++id_bits;
    const std::uint32_t kept = std::min(code_bits, 64 - id_bits);
    const std::uint64_t largest = (std::uint64_t{1} << kept) - 2;
    std::vector<std::uint64_t> keys;
    for (std::size_t i = 0; i < codes.size(); ++i)
        keys.push_back(std::min(codes[i] >> (kCodeBits - kept), largest) << id_bits | ids[i]);
    return keys;
}

MortonOrder morton_order(const Mesh& mesh, MortonCode code, std::uint32_t code_bits) {
    const ActivePrimitives active = active_primitives(mesh);
    std::vector<std::uint64_t> codes = morton_codes(active.bounds, code);
    if (code_bits != kCodeBits) {
        codes = packed_keys(codes, active.ids, mesh.triangles.size(), code_bits);
    }
    std::vector<std::size_t> order(codes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return codes[a] < codes[b]; });

    MortonOrder sorted;
    sorted.primitive_count = mesh.triangles.size();
    for (const std::size_t i : order) {
        sorted.codes.push_back(codes[i]);
        sorted.ids.push_back(active.ids[i]);
        sorted.bounds.push_back(active.bounds[i]);
    }
    if (code == MortonCode::cubic && code_bits != kCodeBits) recode(sorted);
    return sorted;
}

MortonOrder morton_order(const Mesh& mesh, const BuildOptions& options) {
    return morton_order(mesh, options.device.morton_code, options.device.code_bits);
}

}  // namespace clbvh::test
