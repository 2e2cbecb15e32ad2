#include "optimize/candidates.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <functional>
#include <numeric>
#include <tuple>

#include "core/exact_areas.hpp"

namespace clbvh::optimizer {
namespace {

constexpr std::uint32_t kGrain = 8192;
// Sign, exponent and the first bits of the mantissa tell floats above 0 apart well enough: by an eighth.
constexpr std::uint32_t kDroppedBits = 20;
constexpr std::uint32_t kRanks = (1u << (31 - kDroppedBits)) + 1;

std::uint16_t rank_of(float difference) noexcept {
    return static_cast<std::uint16_t>(1 + (std::bit_cast<std::uint32_t>(std::max(difference, 0.0f)) >> kDroppedBits));
}

}  // namespace

Candidates::Candidates(const EditTree& tree) : tree_(tree), ranks_(tree.slot_count(), 0), counts_(kRanks, 0) {
    rate_all();
}

std::span<const std::uint32_t> Candidates::choose(double part) {
    rate_touched();
    collect(find_threshold(part));
    return chosen_;
}

/// Of the two nodes of a pair whose parent has this area.
std::pair<Candidates::Rank, Candidates::Rank> Candidates::ranks_of(std::uint32_t pair, float parent_area) const {
    return {rank_of(parent_area - tree_.box(2 * pair).half_area()),
            rank_of(parent_area - tree_.box(2 * pair + 1).half_area())};
}

void Candidates::rate_all() {
    tbb::enumerable_thread_specific<std::vector<std::uint32_t>> counts(std::size_t{kRanks}, 0u);
    initial_area_ = tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::uint32_t>(1, tree_.slot_count() / 2, kGrain), 0.0,
        [&](const auto& pairs, double area) {
            std::vector<std::uint32_t>& own = counts.local();
            for (std::uint32_t pair = pairs.begin(); pair < pairs.end(); ++pair) {
                const std::uint32_t parent = tree_.parent(2 * pair);
                if (parent == EditTree::kUnused) continue;
                area += exact_half_area(tree_[parent]);
                if (parent == 0) continue;
                std::tie(ranks_[2 * pair], ranks_[2 * pair + 1]) = ranks_of(pair, tree_.box(parent).half_area());
                ++own[ranks_[2 * pair]];
                ++own[ranks_[2 * pair + 1]];
            }
            return area;
        },
        std::plus<>());
    for (const std::vector<std::uint32_t>& own : counts)
        std::ranges::transform(counts_, own, counts_.begin(), std::plus<>());
}

/// A slot that has changed has another difference to its parent, and its children have to it.
void Candidates::rate_touched() {
    tbb::enumerable_thread_specific<std::vector<std::int32_t>> changes(std::size_t{kRanks}, 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, touched_.size(), 512), [&](const auto& range) {
        std::vector<std::int32_t>& own = changes.local();
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::uint32_t slot = touched_[i];
            if (slot != 0) rate_again(slot / 2, own);
            if (!tree_[slot].is_leaf()) rate_again(tree_[slot].first / 2, own);
        }
    });
    touched_.clear();
    for (const std::vector<std::int32_t>& own : changes) {
        for (std::size_t rank = 0; rank < own.size(); ++rank)
            counts_[rank] += static_cast<std::uint32_t>(own[rank]);
    }
}

/// Several threads may rate one pair: they find the same, and the exchange lets only one of them count it.
void Candidates::rate_again(std::uint32_t pair, std::vector<std::int32_t>& changes) {
    const std::uint32_t parent = tree_.parent(2 * pair);
    const auto ranks = parent == 0 ? std::pair<Rank, Rank>() : ranks_of(pair, tree_.box(parent).half_area());
    const auto set = [&](std::uint32_t slot, Rank rank) {
        const Rank before = std::atomic_ref(ranks_[slot]).exchange(rank, std::memory_order_relaxed);
        --changes[before];
        ++changes[rank];
    };
    set(2 * pair, ranks.first);
    set(2 * pair + 1, ranks.second);
}

/// The least rank that is chosen, and how many of it are.
Candidates::Threshold Candidates::find_threshold(double part) const {
    const auto nodes = std::accumulate(counts_.begin() + 1, counts_.end(), std::uint64_t{0});
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
        std::uint32_t above = 0, at = 0;
        for (std::uint32_t slot = begin; slot < end; ++slot) {
            above += ranks_[slot] > threshold.rank;
            at += ranks_[slot] == threshold.rank;
        }
        before[block + 1] = {above, at};
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
