#include "support/oracle/recode_oracle.hpp"

#include <algorithm>
#include <numeric>

#include "clbvh/core/vector.hpp"

namespace clbvh::test {
namespace {

constexpr std::size_t kLongestRun = 32;
constexpr std::uint32_t kWordBits = 64;

struct Run {
    std::size_t begin;
    std::size_t length;
};

std::uint32_t bits_of_count(std::uint64_t count) {
    std::uint32_t bits = 0;
    while (std::uint64_t{1} << bits < count)
        ++bits;
    return bits;
}

bool bit_of(std::uint64_t word, std::uint32_t bit) {
    return (word >> bit & 1u) != 0;
}

std::vector<Run> find_runs(const std::vector<std::uint64_t>& codes, std::uint32_t tie_bits) {
    std::vector<Run> runs;
    for (std::size_t begin = 0; begin < codes.size();) {
        std::size_t end = begin;
        while (end < codes.size() && codes[end] >> tie_bits == codes[begin] >> tie_bits)
            ++end;
        if (end - begin > kLongestRun) runs.push_back({begin, end - begin});
        begin = end;
    }
    return runs;
}

/// Bits at and above `tie_bits` that are the highest to differ between some two keys, in ascending order.
std::vector<std::uint32_t> deciding_bits(const std::vector<std::uint64_t>& codes, std::uint32_t tie_bits) {
    std::vector<std::uint32_t> bits;
    for (std::uint32_t bit = tie_bits; bit < kWordBits; ++bit) {
        for (std::size_t i = 1; i < codes.size(); ++i) {
            const std::uint64_t above = bit + 1 < kWordBits ? (codes[i - 1] ^ codes[i]) >> (bit + 1) : 0;
            if (above != 0 || !bit_of(codes[i - 1] ^ codes[i], bit)) continue;
            bits.push_back(bit);
            break;
        }
    }
    return bits;
}

/// Moves the bits that decide to the top. Returns how many bits are left below.
std::uint32_t pack(std::vector<std::uint64_t>& codes, std::uint32_t tie_bits) {
    const std::vector<std::uint32_t> bits = deciding_bits(codes, tie_bits);
    const auto left = std::min(kWordBits - static_cast<std::uint32_t>(bits.size()), kWordBits - 1);
    for (std::uint64_t& code : codes) {
        std::uint64_t packed = code & ((std::uint64_t{1} << tie_bits) - 1);
        for (std::size_t k = 0; k < bits.size(); ++k)
            packed |= std::uint64_t{bit_of(code, bits[k])} << (left + k);
        code = packed;
    }
    return left;
}

void recode_run(MortonOrder& order, const Run& run, std::uint32_t available, std::uint32_t tie_bits) {
    const std::vector<Aabb> boxes(order.bounds.begin() + static_cast<std::ptrdiff_t>(run.begin),
                                  order.bounds.begin() + static_cast<std::ptrdiff_t>(run.begin + run.length));
    const std::vector<std::uint32_t> ids(order.ids.begin() + static_cast<std::ptrdiff_t>(run.begin),
                                         order.ids.begin() + static_cast<std::ptrdiff_t>(run.begin + run.length));
    const Aabb centroids = scene_bounds(boxes).doubled_centroids;
    const Vec3 extent = centroids.upper - centroids.lower;
    if (!(extent.x > 0 || extent.y > 0 || extent.z > 0)) return;
    const std::uint32_t code_bits = std::min(available - tie_bits, 63u);
    std::vector<std::uint64_t> codes = morton_codes(boxes, MortonCode::cubic);
    for (std::uint64_t& code : codes)
        code >>= 63 - code_bits;
    std::vector<std::size_t> sorted(run.length);
    std::iota(sorted.begin(), sorted.end(), std::size_t{0});
    std::ranges::stable_sort(sorted, {}, [&](std::size_t i) { return codes[i]; });
    const std::uint64_t prefix = order.codes[run.begin] >> available << available;
    for (std::size_t i = 0; i < run.length; ++i) {
        order.codes[run.begin + i] = prefix | codes[sorted[i]] << tie_bits | i;
        order.ids[run.begin + i] = ids[sorted[i]];
        order.bounds[run.begin + i] = boxes[sorted[i]];
    }
}

}  // namespace

void recode(MortonOrder& order) {
    std::uint32_t tie_bits = bits_of_count(order.primitive_count);
    for (int round = 0; round < 2; ++round) {
        const std::vector<Run> runs = find_runs(order.codes, tie_bits);
        if (runs.empty()) return;
        const std::size_t longest = std::ranges::max_element(runs, {}, &Run::length)->length;
        const bool packs = 2 * bits_of_count(longest) + 3 > tie_bits;
        const std::uint32_t available = packs ? pack(order.codes, tie_bits) : tie_bits;
        for (const Run& run : runs)
            recode_run(order, run, available, bits_of_count(packs ? longest : run.length));
        if (!packs) return;
        tie_bits = bits_of_count(longest);
    }
}

}  // namespace clbvh::test
