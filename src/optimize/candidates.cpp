#include "optimize/candidates.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <numeric>

namespace clbvh::optimize {
namespace {

constexpr std::uint32_t kGrain = 8192;
// Sign, exponent and the first bits of the mantissa tell floats above 0 apart well enough: by an eighth.
constexpr std::uint32_t kDroppedBits = 20;
constexpr std::uint32_t kRanks = (1u << (31 - kDroppedBits)) + 1;

std::uint32_t rank_of(float difference) noexcept {
    return 1 + (std::bit_cast<std::uint32_t>(std::max(difference, 0.0f)) >> kDroppedBits);
}

}  // namespace

std::span<const std::uint32_t> Candidates::choose(const EditTree& tree, double part) {
    rate(tree);
    collect(find_threshold(part));
    return chosen_;
}

void Candidates::rate(const EditTree& tree) {
    ranks_.assign(tree.slot_count(), 0);
    tbb::enumerable_thread_specific<std::vector<std::uint32_t>> counts(std::size_t{kRanks}, 0u);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(1, tree.slot_count() / 2, kGrain), [&](const auto& pairs) {
        std::vector<std::uint32_t>& own = counts.local();
        for (std::uint32_t pair = pairs.begin(); pair < pairs.end(); ++pair) {
            const std::uint32_t parent = tree.parent(2 * pair);
            if (parent == EditTree::kUnused || parent == 0) continue;
            const float area = tree.box(parent).half_area();
            for (const std::uint32_t slot : {2 * pair, 2 * pair + 1})
                ++own[ranks_[slot] = rank_of(area - tree.box(slot).half_area())];
        }
    });
    counts_.assign(kRanks, 0);
    for (const std::vector<std::uint32_t>& own : counts)
        std::ranges::transform(counts_, own, counts_.begin(), std::plus<>());
}

/// The least rank that is chosen.
std::uint32_t Candidates::find_threshold(double part) const {
    const double wanted = part * static_cast<double>(std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}));
    std::uint32_t threshold = kRanks;
    std::uint64_t chosen = 0;
    while (threshold > 1 && (chosen == 0 || static_cast<double>(chosen + counts_[threshold - 1]) <= wanted))
        chosen += counts_[--threshold];
    return threshold;
}

void Candidates::collect(std::uint32_t threshold) {
    const std::uint32_t slots = static_cast<std::uint32_t>(ranks_.size());
    std::vector<std::uint32_t> ends((slots + kGrain - 1) / kGrain + 1, 0);
    const auto for_each_block = [&](const auto& work) {
        tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(ends.size() - 1), [&](std::uint32_t block) {
            work(block, block * kGrain, std::min(slots, (block + 1) * kGrain));
        });
    };
    for_each_block([&](std::uint32_t block, std::uint32_t begin, std::uint32_t end) {
        ends[block + 1] = static_cast<std::uint32_t>(
            std::count_if(ranks_.begin() + begin, ranks_.begin() + end, [&](auto rank) { return rank >= threshold; }));
    });
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    chosen_.resize(ends.back());
    for_each_block([&](std::uint32_t block, std::uint32_t begin, std::uint32_t end) {
        std::uint32_t next = ends[block];
        for (std::uint32_t slot = begin; slot < end; ++slot) {
            if (ranks_[slot] >= threshold) chosen_[next++] = slot;
        }
    });
}

}  // namespace clbvh::optimize
