#include "host/agglomerative/refine_codes.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <vector>

#include "host/agglomerative/morton.hpp"
#include "kernels/build/build_constants.h"

namespace clbvh::host {
namespace {

struct CodedReference {
    std::uint64_t code;
    std::uint32_t reference;

    [[nodiscard]] auto operator<=>(const CodedReference&) const noexcept = default;
};

struct Run {
    std::size_t begin;
    std::size_t end;
};

/// Runs of more than LONGEST_RUN equal codes. `code(i)` is the i-th of `count`.
template <typename Code>
std::vector<Run> find_runs(std::size_t count, const Code& code) {
    std::vector<Run> runs;
    for (std::size_t begin = 0; begin + kernels::LONGEST_RUN < count;) {
        if (code(begin) != code(begin + kernels::LONGEST_RUN)) {
            ++begin;
            continue;
        }
        std::size_t end = begin + kernels::LONGEST_RUN + 1;
        while (end < count && code(end) == code(begin))
            ++end;
        runs.push_back({begin, end});
        begin = end;
    }
    return runs;
}

/// The bits that are the highest to differ between any two codes.
template <typename Code>
std::uint64_t deciding_bits(std::size_t count, const Code& code) {
    std::uint64_t bits = 0;
    for (std::size_t i = 1; i < count; ++i)
        bits |= std::bit_floor(code(i - 1) ^ code(i));
    return bits;
}

/// The bits of `code` that `mask` has, side by side.
std::uint64_t pick_bits(std::uint64_t code, std::uint64_t mask) {
    std::uint64_t picked = 0;
    for (std::uint32_t at = 0; mask != 0; mask &= mask - 1, ++at)
        picked |= (code >> std::countr_zero(mask) & 1u) << at;
    return picked;
}

Box4 centroids_of(std::span<const std::uint32_t> ids, std::span<const Reference> references) {
    Box4 bounds;
    for (const std::uint32_t id : ids)
        bounds.merge(Box4::of(references[id]).doubled_centroid());
    return bounds;
}

bool has_extent(const Box4& box) {
    const Float4 extent = box.upper - box.lower;
    return extent.x() > 0.0f || extent.y() > 0.0f || extent.z() > 0.0f;
}

/// Gives a run of equal codes, whose low `free_bits` bits are 0, codes in these bits.
void refine_run(std::span<std::uint64_t> codes, std::span<std::uint32_t> ids, std::uint32_t free_bits,
                std::span<const Reference> references) {
    const Box4 centroids = centroids_of(ids, references);
    if (free_bits == 0 || !has_extent(centroids)) return;
    const std::uint32_t bits = std::min(free_bits, 63u);
    const MortonGrid grid = MortonGrid::cubic(centroids, bits);
    const std::uint64_t prefix = codes[0];
    std::vector<CodedReference> run;
    run.reserve(ids.size());
    for (const std::uint32_t id : ids)
        run.push_back({grid.code_of(references[id]), id});
    tbb::parallel_sort(run.begin(), run.end());
    const auto code = [&](std::size_t i) { return run[i].code; };
    const std::vector<Run> runs = find_runs(run.size(), code);
    const std::uint64_t deciding = runs.empty() ? 0 : deciding_bits(run.size(), code);
    const auto used = static_cast<std::uint32_t>(std::popcount(deciding));
    if (!runs.empty() && used == 0) return;
    for (std::size_t i = 0; i < run.size(); ++i) {
        codes[i] = prefix | (runs.empty() ? run[i].code : pick_bits(run[i].code, deciding) << (bits - used));
        ids[i] = run[i].reference;
    }
    for (const Run& r : runs) {
        const std::size_t length = r.end - r.begin;
        refine_run(codes.subspan(r.begin, length), ids.subspan(r.begin, length), bits - used, references);
    }
}

}  // namespace

void refine_codes(const KeyedValues<std::uint64_t>& sorted, std::span<const Reference> references) {
    const std::span<std::uint64_t> codes = sorted.keys;
    const auto code = [&](std::size_t i) { return codes[i]; };
    const std::vector<Run> runs = find_runs(codes.size(), code);
    if (runs.empty()) return;
    const std::uint64_t deciding = deciding_bits(codes.size(), code);
    const auto free_bits = static_cast<std::uint32_t>(std::min(64 - std::popcount(deciding), 63));
    tbb::parallel_for(std::size_t{0}, codes.size(),
                      [&](std::size_t i) { codes[i] = pick_bits(codes[i], deciding) << free_bits; });
    tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t k) {
        const std::size_t length = runs[k].end - runs[k].begin;
        refine_run(codes.subspan(runs[k].begin, length), sorted.values.subspan(runs[k].begin, length), free_bits,
                   references);
    });
}

}  // namespace clbvh::host
