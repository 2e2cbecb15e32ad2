// Binned SAH. Wald 2007, "On fast construction of SAH-based bounding volume hierarchies".
//
// References move between two arrays: each split copies its range from one to the other, left part ascending, right
// part descending, without a branch on the side. Ranges of many references are binned and split by many threads.
#include "host/top_down/binned_sah.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/check_field.hpp"
#include "host/build/cost_unit.hpp"
#include "host/top_down/binned_move.hpp"
#include "host/top_down/range_tree.hpp"

namespace clbvh::host {
namespace {

/// Ranges from this size on are split by two tasks, which may go on in parallel.
constexpr std::uint32_t kParallelSubtree = 2048;
/// Ranges from this size on are themselves binned and moved in parallel, in chunks of kChunk.
constexpr std::uint32_t kParallelRange = 1u << 16;
constexpr std::uint32_t kChunk = 1u << 13;

/// A range of references that becomes a subtree.
struct Job {
    std::uint32_t slot;   ///< Node of its root.
    std::uint32_t begin;  ///< First position.
    std::uint32_t end;    ///< One behind the last.
    std::uint32_t depth;  ///< Edges above its root.
    Box4 box;
    Box4 centroids;  ///< Bounds of the doubled centroids.

    [[nodiscard]] std::uint32_t size() const noexcept { return end - begin; }
};

/// The two arrays: where a range lies, and where its halves go.
struct Arrays {
    Reference* current;
    Reference* other;
};

/// How a range was divided. Without a border it is to become a leaf.
struct Division {
    std::uint32_t border = 0;  ///< Position where the right half begins; 0: none.
    Sides sides;
    Arrays arrays;  ///< Of the halves.
};

class BinnedSahBuilder {
public:
    BinnedSahBuilder(HostBuild& build, const BinnedSahConfig& config)
        : build_(build), config_(config), tree_(build.scratch, build.references.size()) {}

    void run() {
        const auto count = static_cast<std::uint32_t>(build_.references.size());
        build_.stages.begin("build", 0.05, 0.95, count);
        const Arrays arrays{build_.references.data(), build_.scratch.take<Reference>(count).data()};
        build_subtree({0, 0, count, 0, build_.bounds.box, build_.bounds.centroids}, arrays);
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree(tree_.slots(), build_.result);
    }

private:
    Extent build_subtree(const Job& job, const Arrays& arrays) {
        if (job.size() < kParallelSubtree) {
            std::uint32_t next_pair = job.begin + 1;
            const Extent extent = build_sequentially(job, arrays, next_pair);
            build_.stages.advance(job.size());
            return extent;
        }
        const Division division = divide(job, arrays);
        const std::array<Job, 2> halves = children(job, division, division.border);
        Extent left_extent, right_extent;
        tbb::parallel_invoke([&] { left_extent = build_subtree(halves[0], division.arrays); },
                             [&] { right_extent = build_subtree(halves[1], division.arrays); });
        return tree_.set_inner(job.slot, job.box, division.border, left_extent, right_extent);
    }

    Extent build_sequentially(const Job& job, const Arrays& arrays, std::uint32_t& next_pair) {
        const Division division = job.size() > 1 ? divide(job, arrays) : Division{};
        if (division.border == 0) {
            return tree_.set_leaf(job.slot, job.box, job.begin, {arrays.current + job.begin, job.size()});
        }
        const std::uint32_t pair = next_pair++;
        const auto [left, right] = children(job, division, pair);
        const Extent left_extent = build_sequentially(left, division.arrays, next_pair);
        const Extent right_extent = build_sequentially(right, division.arrays, next_pair);
        return tree_.set_inner(job.slot, job.box, pair, left_extent, right_extent);
    }

    static std::array<Job, 2> children(const Job& job, const Division& division, std::uint32_t pair) {
        const std::uint32_t slot = RangeTree::left_child(pair);
        const auto& [left, right] = division.sides;
        return {{{slot, job.begin, division.border, job.depth + 1, left.box, left.centroids},
                 {slot + 1, division.border, job.end, job.depth + 1, right.box, right.centroids}}};
    }

    // Not inlined: bins would stay on the stack while subtrees are built.
    [[gnu::noinline]] Division divide(const Job& job, const Arrays& arrays) const {
        const Binning binning(job.centroids, config_.bin_count, config_.longest_axis_only);
        if (job.depth >= kMaxSahDepth) return job.size() <= config_.max_leaf_size ? Division{} : halve(job, arrays);
        if (job.size() >= kParallelRange) return divide_in_parallel(job, arrays, binning);
        const std::span<const Reference> range(arrays.current + job.begin, job.size());
        const float unit = cost_unit(job.box.half_area());
        BinnedSplit split;
        if (job.size() <= kFewReferences) {
            split = find_split_of_few(range, binning, unit);
        } else {
            BinSet bins(config_.bin_count);
            bins.add(range, binning);
            split = bins.find_split(unit);
        }
        if (becomes_leaf(job, split, unit)) return {};
        if (!split.found()) return halve(job, arrays);
        Division division{0, {}, {arrays.other, arrays.current}};
        division.border = job.begin + move_references(range, binning, split, arrays.other + job.begin,
                                                      arrays.other + job.end, division.sides);
        return division;
    }

    [[nodiscard]] bool becomes_leaf(const Job& job, const BinnedSplit& split, float unit) const {
        if (job.size() > config_.max_leaf_size) return false;
        if (!split.found()) return true;
        const float area = job.box.half_area() * unit;
        return config_.primitive_cost * static_cast<float>(job.size()) * area <=
               config_.inner_cost * area + config_.primitive_cost * split.cost;
    }

    /// Large ranges only, which never become leaves. Every chunk keeps its bins, which tell where its parts go.
    Division divide_in_parallel(const Job& job, const Arrays& arrays, const Binning& binning) const {
        const std::uint32_t chunk_count = (job.size() + kChunk - 1) / kChunk;
        std::vector<BinSet> bins(chunk_count, BinSet(config_.bin_count));
        const auto chunk = [&](std::uint32_t c) {
            return std::span<const Reference>(arrays.current + job.begin + std::size_t{c} * kChunk,
                                              std::min(kChunk, job.size() - c * kChunk));
        };
        tbb::parallel_for(0u, chunk_count, [&](std::uint32_t c) { bins[c].add(chunk(c), binning); });
        BinSet all = bins[0];
        for (std::uint32_t c = 1; c < chunk_count; ++c)
            all.add(bins[c]);
        const BinnedSplit split = all.find_split(cost_unit(job.box.half_area()));
        if (!split.found()) return halve(job, arrays);

        std::vector<std::uint32_t> lefts_before(chunk_count + 1, job.begin);
        for (std::uint32_t c = 0; c < chunk_count; ++c)
            lefts_before[c + 1] = lefts_before[c] + bins[c].count_left_of(split);
        Division division{lefts_before.back(), {}, {arrays.other, arrays.current}};
        std::vector<Sides> sides(chunk_count);
        tbb::parallel_for(0u, chunk_count, [&](std::uint32_t c) {
            const std::uint32_t rights_before = c * kChunk - (lefts_before[c] - job.begin);
            move_references(chunk(c), binning, split, arrays.other + lefts_before[c],
                            arrays.other + job.end - rights_before, sides[c]);
        });
        for (const Sides& part : sides) {
            division.sides[0].add(part[0]);
            division.sides[1].add(part[1]);
        }
        return division;
    }

    /// Two halves in the order of ids, where centroids do not tell primitives apart.
    static Division halve(const Job& job, const Arrays& arrays) {
        const std::span<Reference> range(arrays.current + job.begin, job.size());
        if (!std::ranges::is_sorted(range, {}, &Reference::primitive)) {
            std::ranges::sort(range, {}, &Reference::primitive);
        }
        const std::uint32_t half = job.size() / 2;
        Division division{job.begin + half, {}, arrays};
        for (std::uint32_t i = 0; i < job.size(); ++i)
            division.sides[i < half ? 0 : 1].add(range[i]);
        return division;
    }

    HostBuild& build_;
    BinnedSahConfig config_;
    RangeTree tree_;
};

void check(const BinnedSahConfig& config) {
    check_field("bin_count", config.bin_count, kBinCounts);
    check_positive("inner_cost", config.inner_cost);
    check_positive("primitive_cost", config.primitive_cost);
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
}

}  // namespace

void build_binned_sah(HostBuild& build, const BinnedSahConfig& config) {
    BinnedSahBuilder(build, config).run();
}

void build_binned_sah(std::span<const Aabb> bounds, const BinnedSahConfig& config, Scratch& scratch, Bvh& result) {
    check(config);
    build_over(
        bounds, [&](HostBuild& build) { build_binned_sah(build, config); }, scratch, result);
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_binned_sah(const Primitives& primitives, const BinnedSahConfig& config) {
    host::check(config);
    return host::build_over(primitives, [&](host::HostBuild& build) { host::build_binned_sah(build, config); });
}

}  // namespace clbvh
