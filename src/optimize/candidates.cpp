#include "optimize/candidates.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <numeric>

namespace clbvh::optimizer {
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

/// The least rank that is chosen, and how many of it are.
Candidates::Threshold Candidates::find_threshold(double part) const {
    const auto nodes = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
    const auto wanted = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(part * static_cast<double>(nodes)));
    std::uint64_t above = 0;
    std::uint32_t rank = kRanks - 1;
    while (rank > 1 && above + counts_[rank] < wanted)
        above += counts_[rank--];
    return {rank, counts_[rank], std::min<std::uint64_t>(counts_[rank], wanted - above)};
}

void Candidates::collect(const Threshold& threshold) {
    const std::uint32_t slots = static_cast<std::uint32_t>(ranks_.size());
    struct Counts {
        std::uint32_t above = 0;
        std::uint64_t at = 0;
    };
    std::vector<Counts> before((slots + kGrain - 1) / kGrain + 1);  // of block b: in all blocks before it
    const auto for_each_block = [&](const auto& work) {
        tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(before.size() - 1), [&](std::uint32_t block) {
            work(block, block * kGrain, std::min(slots, (block + 1) * kGrain));
        });
    };
    for_each_block([&](std::uint32_t block, std::uint32_t begin, std::uint32_t end) {
        Counts counts;
        for (std::uint32_t slot = begin; slot < end; ++slot) {
            counts.above += ranks_[slot] > threshold.rank;
            counts.at += ranks_[slot] == threshold.rank;
        }
        before[block + 1] = counts;
    });
    std::partial_sum(before.begin(), before.end(), before.begin(), [](const Counts& a, const Counts& b) {
        return Counts{a.above + b.above, a.at + b.at};
    });
    // Of those at the threshold the k-th is taken where the quota's share of the first k + 1 is a new number: evenly.
    const auto taken = [&](std::uint64_t first) {
        return threshold.count > 0 ? first * threshold.quota / threshold.count : 0;
    };
    chosen_.resize(before.back().above + taken(before.back().at));
    for_each_block([&](std::uint32_t block, std::uint32_t begin, std::uint32_t end) {
        std::uint64_t at = before[block].at;
        std::size_t next = before[block].above + taken(at);
        for (std::uint32_t slot = begin; slot < end; ++slot) {
            bool is_chosen = ranks_[slot] > threshold.rank;
            if (ranks_[slot] == threshold.rank) {
                is_chosen = taken(at + 1) > taken(at);
                ++at;
            }
            if (is_chosen) chosen_[next++] = slot;
        }
    });
}

}  // namespace clbvh::optimizer
