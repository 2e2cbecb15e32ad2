// Binned SAH. Wald 2007, "On fast construction of SAH-based bounding volume hierarchies".
//
// References move between two arrays: each split copies its range from one to the other, left part ascending, right
// part descending, without a branch on the side. Ranges of many references are binned and split by many threads.
#include "host/binned_sah.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/check_field.hpp"
#include "host/binning.hpp"
#include "host/range_tree.hpp"

namespace clbvh::host {
namespace {

/// Beyond this depth ranges are halved, so that no input makes a tree that is much deeper.
constexpr std::uint32_t kMaxSahDepth = 256;
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

/// What moves to one side of a split.
struct Side {
    Box4 box;
    Box4 centroids;

    void add(const Reference& reference) noexcept {
        const Box4 reference_box = Box4::of(reference);
        box.merge(reference_box);
        centroids.merge(reference_box.doubled_centroid());
    }
    void add(const Side& side) noexcept {
        box.merge(side.box);
        centroids.merge(side.centroids);
    }
};
using Sides = std::array<Side, 2>;

/// How a range was divided. Without a border it is to become a leaf.
struct Division {
    std::uint32_t border = 0;  ///< Position where the right half begins; 0: none.
    Sides sides;
    Arrays arrays;  ///< Of the halves.
};

/// Moves lefts to `left` ascending and rights to below `right` descending, and adds them to `sides`.
/// Returns the number of lefts.
std::uint32_t move(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split, Reference* left,
                   Reference* right, Sides& sides) noexcept {
    const Reference* const first_left = left;
    for (const Reference& reference : range) {
        std::int32_t bins[4];
        binning.bins_of(reference, bins);
        const bool goes_right = static_cast<std::uint32_t>(bins[split.axis]) >= split.bin;
        sides[goes_right].add(reference);
        right -= goes_right;
        *(goes_right ? right : left) = reference;
        left += !goes_right;
    }
    return static_cast<std::uint32_t>(left - first_left);
}

class BinnedSahBuilder {
public:
    BinnedSahBuilder(HostBuild& build, const BinnedSahConfig& config)
        : build_(build), config_(config), tree_(build.scratch, build.references.size()) {}

    void run() {
        const auto count = static_cast<std::uint32_t>(build_.references.size());
        build_.stages.begin("build", 0.05, 0.95, count);
        const Arrays arrays{build_.references.data(), build_.scratch.take<Reference>(count).data()};
        const Side whole = bound(build_.references);
        build_subtree({0, 0, count, 0, whole.box, whole.centroids}, arrays);
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree(tree_.slots(), build_.result);
    }

private:
    static Side bound(std::span<const Reference> references) {
        return tbb::parallel_reduce(
            tbb::blocked_range<std::size_t>(0, references.size(), kChunk), Side{},
            [&](const auto& range, Side side) {
                for (std::size_t i = range.begin(); i < range.end(); ++i)
                    side.add(references[i]);
                return side;
            },
            [](Side a, const Side& b) {
                a.add(b);
                return a;
            });
    }

    Extent build_subtree(const Job& job, const Arrays& arrays) {
        const Division division = job.size() > 1 ? divide(job, arrays) : Division{};
        if (division.border == 0) {
            return tree_.set_leaf(job.slot, job.box, job.begin, {arrays.current + job.begin, job.size()});
        }
        const std::uint32_t slot = RangeTree::left_child(division.border);
        const auto& [left_side, right_side] = division.sides;
        const Job left{slot, job.begin, division.border, job.depth + 1, left_side.box, left_side.centroids};
        const Job right{slot + 1, division.border, job.end, job.depth + 1, right_side.box, right_side.centroids};
        Extent left_extent, right_extent;
        if (job.size() < kParallelSubtree) {
            left_extent = build_subtree(left, division.arrays);
            right_extent = build_subtree(right, division.arrays);
        } else {
            tbb::parallel_invoke([&] { left_extent = build_task(left, division.arrays); },
                                 [&] { right_extent = build_task(right, division.arrays); });
        }
        return tree_.set_inner(job.slot, job.box, division.border, left_extent, right_extent);
    }

    Extent build_task(const Job& job, const Arrays& arrays) {
        const Extent extent = build_subtree(job, arrays);
        if (job.size() < kParallelSubtree) build_.stages.advance(job.size());
        return extent;
    }

    // Not inlined: bins would stay on the stack while subtrees are built.
    [[gnu::noinline]] Division divide(const Job& job, const Arrays& arrays) const {
        const Binning binning(job.centroids, config_.bin_count, config_.longest_axis_only);
        if (job.depth >= kMaxSahDepth) return job.size() <= config_.max_leaf_size ? Division{} : halve(job, arrays);
        if (job.size() >= kParallelRange) return divide_in_parallel(job, arrays, binning);
        const std::span<const Reference> range(arrays.current + job.begin, job.size());
        BinnedSplit split;
        if (job.size() <= kFewReferences) {
            split = find_split_of_few(range, binning);
        } else {
            BinSet bins(config_.bin_count);
            bins.add(range, binning);
            split = bins.find_split(binning);
        }
        if (becomes_leaf(job, split)) return {};
        if (!split.found()) return halve(job, arrays);
        Division division{0, {}, {arrays.other, arrays.current}};
        division.border =
            job.begin + move(range, binning, split, arrays.other + job.begin, arrays.other + job.end, division.sides);
        return division;
    }

    [[nodiscard]] bool becomes_leaf(const Job& job, const BinnedSplit& split) const {
        if (job.size() > config_.max_leaf_size) return false;
        if (!split.found()) return true;
        const float area = job.box.half_area();
        return config_.primitive_cost * static_cast<float>(job.size()) * area <=
               config_.inner_cost * area + config_.primitive_cost * split.cost;
    }

    /// Large ranges only, which never become leaves. Every chunk keeps its bins, which tell where its parts go.
    Division divide_in_parallel(const Job& job, const Arrays& arrays, const Binning& binning) const {
        const std::uint32_t chunk_count = (job.size() + kChunk - 1) / kChunk;
        std::vector<BinSet> bins(chunk_count, BinSet(config_.bin_count));
        const auto chunk = [&](std::uint32_t c) {
            return std::span<const Reference>(arrays.current + job.begin + c * kChunk,
                                              std::min(kChunk, job.size() - c * kChunk));
        };
        tbb::parallel_for(0u, chunk_count, [&](std::uint32_t c) { bins[c].add(chunk(c), binning); });
        BinSet all = bins[0];
        for (std::uint32_t c = 1; c < chunk_count; ++c)
            all.add(bins[c]);
        const BinnedSplit split = all.find_split(binning);
        if (!split.found()) return halve(job, arrays);

        std::vector<std::uint32_t> lefts_before(chunk_count + 1, job.begin);
        for (std::uint32_t c = 0; c < chunk_count; ++c)
            lefts_before[c + 1] = lefts_before[c] + bins[c].count_left_of(split);
        Division division{lefts_before.back(), {}, {arrays.other, arrays.current}};
        std::vector<Sides> sides(chunk_count);
        tbb::parallel_for(0u, chunk_count, [&](std::uint32_t c) {
            const std::uint32_t rights_before = c * kChunk - (lefts_before[c] - job.begin);
            move(chunk(c), binning, split, arrays.other + lefts_before[c], arrays.other + job.end - rights_before,
                 sides[c]);
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
    check_range("bin_count", config.bin_count, 2, kMaxBinCount);
    check_positive("inner_cost", config.inner_cost);
    check_positive("primitive_cost", config.primitive_cost);
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
}

}  // namespace

void build_binned_sah(HostBuild& build, const BinnedSahConfig& config) {
    BinnedSahBuilder(build, config).run();
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_binned_sah(std::span<const Aabb> bounds, const BinnedSahConfig& config) {
    host::check(config);
    return host::build_over_boxes(bounds, [&](host::HostBuild& build) { host::build_binned_sah(build, config); });
}

}  // namespace clbvh
