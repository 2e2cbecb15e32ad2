// Spatial splits. Stich, Friedrich, Dietrich 2009, "Spatial splits in bounding volume hierarchies".
//
// As in binned SAH, references move between two arrays. A range of references lies in a range of positions that has
// spare ones, which cut references may fill; those that are left are dealt out to both halves. So the memory is
// bounded, and every subtree knows what it may spend, whichever thread builds it when.
#include "host/top_down/sbvh.hpp"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>

#include "core/check_field.hpp"
#include "host/top_down/range_tree.hpp"
#include "host/top_down/sbvh_move.hpp"

namespace clbvh::host {
namespace {

/// Ranges from this size on are split by two tasks, which may go on in parallel.
constexpr std::uint32_t kParallelSubtree = 1024;

/// A range of references that becomes a subtree.
struct Job {
    std::uint32_t slot;  ///< Node of its root.
    SpacedRange range;
    std::uint32_t depth;  ///< Edges above its root.
    Bounds bounds;
};

/// Where a range lies, where its halves go, and where theirs go.
struct Arrays {
    Reference* current;
    Reference* next;
    Reference* after_next;

    [[nodiscard]] Arrays of_halves() const noexcept { return {next, after_next, next}; }
};

/// The halves of a job. Without a border it is to become a leaf.
struct Split {
    std::uint32_t border = 0;  ///< Where the right half's positions begin; 0: none.
    std::array<SpacedRange, 2> ranges{};
    Halves halves{};
    Arrays arrays{};
};

/// A split of the references as they are.
struct ObjectSplit {
    BinnedSplit split;
    float overlap = 0.0f;  ///< Half area of what the boxes of both halves share; 0 where nothing may be cut.
};

/// The boxes of what a rule sends to either side.
struct BoxesOfHalves {
    std::array<Box4, 2> boxes;

    void put(const Reference& reference, bool goes_right) noexcept {
        boxes[goes_right ? 1 : 0].merge(Box4::of(reference));
    }
};

class SbvhBuilder {
public:
    SbvhBuilder(HostBuild& build, const SbvhConfig& config)
        : build_(build),
          config_(config),
          capacity_(most_references(build.references.size(), config.reference_budget)),
          tree_(build.scratch, capacity_) {}

    void run() {
        const auto count = static_cast<std::uint32_t>(build_.references.size());
        build_.stages.begin("build", 0.05, 0.95, count);
        Reference* const first = build_.scratch.take<Reference>(capacity_).data();
        Reference* const second = build_.scratch.take<Reference>(capacity_).data();
        const SpacedRange range{0, capacity_, 0, count};
        least_overlap_ = config_.alpha * build_.bounds.box.half_area();
        build_subtree({0, range, 0, build_.bounds}, {build_.references.data(), first, second});
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree(tree_.slots(), build_.result);
        build_.result.split_references = capacity_ > count;
    }

private:
    static std::uint32_t most_references(std::size_t count, float budget) {
        const double allowed = double{budget} * static_cast<double>(count);
        return static_cast<std::uint32_t>(std::min(allowed, static_cast<double>(kMaxPrimitives)));
    }

    Extent build_subtree(const Job& job, const Arrays& arrays) {
        const auto& [begin, end, first, count] = job.range;
        const Split split = count > 1 ? divide(job, arrays) : Split{};
        if (split.border == 0) return tree_.set_leaf(job.slot, job.bounds.box, begin, {arrays.current + first, count});
        const std::uint32_t slot = RangeTree::left_child(split.border);
        const Job left{slot, split.ranges[0], job.depth + 1, split.halves[0].bounds};
        const Job right{slot + 1, split.ranges[1], job.depth + 1, split.halves[1].bounds};
        Extent left_extent, right_extent;
        if (count < kParallelSubtree) {
            left_extent = build_subtree(left, split.arrays);
            right_extent = build_subtree(right, split.arrays);
        } else {
            tbb::parallel_invoke([&] { left_extent = build_task(left, split.arrays); },
                                 [&] { right_extent = build_task(right, split.arrays); });
        }
        // Not the job's box: the parts of a reference that was cut before, and grown by the error of that, need not
        // reach as far as it did.
        return tree_.set_inner(job.slot, tree_.box_of(split.border), split.border, left_extent, right_extent);
    }

    Extent build_task(const Job& job, const Arrays& arrays) {
        const Extent extent = build_subtree(job, arrays);
        if (job.range.count < kParallelSubtree) build_.stages.advance(job.range.count);
        return extent;
    }

    // Not inlined: bins would stay on the stack while subtrees are built.
    [[gnu::noinline]] Split divide(const Job& job, const Arrays& arrays) const {
        if (job.depth >= kMaxSahDepth) {
            return job.range.count <= config_.max_leaf_size ? Split{} : halve(job.range, arrays);
        }
        const Binning binning(job.bounds.centroids, config_.bin_count, false);
        const ObjectSplit object = find_object_split(job, arrays.current, binning);
        if (may_cut(job) && (!object.split.found() || object.overlap > least_overlap(job))) {
            const SpatialBinning spatial_binning(job.bounds.box, config_.spatial_bin_count);
            const SpatialSplit spatial = find_spatial_split(job.range, arrays.current, spatial_binning);
            if (spatial.cost < (object.split.found() ? object.split.cost : halving_cost(job))) {
                if (becomes_leaf(job, spatial.cost)) return {};
                const Split cut = move(job.range, arrays, SpatialRule(build_.mesh, spatial_binning, spatial));
                if (cut.border > 0) return cut;
            }
        }
        if (becomes_leaf(job, object.split.cost)) return {};
        return object.split.found() ? move(job.range, arrays, ObjectRule{binning, object.split})
                                    : halve(job.range, arrays);
    }

    [[nodiscard]] static bool may_cut(const Job& job) noexcept { return job.range.capacity() > job.range.count; }

    /// Of an object split's children, above which planes are tried: of the scene for the paper's sake, and of the node,
    /// since the budget is better spent where a plane has much to take apart.
    [[nodiscard]] float least_overlap(const Job& job) const noexcept {
        return std::max(least_overlap_, config_.overlap * job.bounds.box.half_area());
    }

    [[nodiscard]] bool becomes_leaf(const Job& job, float split_cost) const {
        if (job.range.count > config_.max_leaf_size) return false;
        const float area = weighted_area(job);
        return config_.primitive_cost * static_cast<float>(job.range.count) * area <=
               config_.inner_cost * area + config_.primitive_cost * split_cost;
    }

    /// Of two halves, each as large as the whole; as SpatialSplit::cost.
    static float halving_cost(const Job& job) noexcept {
        return weighted_area(job) * static_cast<float>(job.range.count);
    }

    static float weighted_area(const Job& job) noexcept {
        const float area = job.bounds.box.half_area();
        return area * cost_unit(area);
    }

    static float overlap_of(const std::array<Box4, 2>& halves) noexcept {
        const Box4 shared = intersect(halves[0], halves[1]);
        return has_point(shared) ? shared.half_area() : 0.0f;
    }

    [[nodiscard]] ObjectSplit find_object_split(const Job& job, const Reference* references,
                                                const Binning& binning) const {
        const float area = job.bounds.box.half_area();
        const float unit = cost_unit(area);
        // The overlap of both halves is no larger than the whole.
        const bool needs_overlap = may_cut(job) && area > least_overlap_;
        if (job.range.count <= kFewReferences) {
            const std::span<const Reference> few = job.range.chunk(references, 0);
            const ObjectRule rule{binning, find_split_of_few(few, binning, unit)};
            if (!needs_overlap || !rule.split.found()) return {rule.split};
            BoxesOfHalves boxes;
            for (const Reference& reference : few)
                rule(reference, boxes);
            return {rule.split, overlap_of(boxes.boxes)};
        }
        BinSet bins(config_.bin_count);
        add_chunks(job.range, references, bins, [&](BinSet& sum, const auto& chunk) { sum.add(chunk, binning); });
        const BinnedSplit split = bins.find_split(unit);
        if (!needs_overlap || !split.found()) return {split};
        return {split, overlap_of(bins.boxes_of(split))};
    }

    [[nodiscard]] SpatialSplit find_spatial_split(const SpacedRange& range, const Reference* references,
                                                  const SpatialBinning& binning) const {
        SpatialBinSet bins(config_.spatial_bin_count);
        add_chunks(range, references, bins,
                   [&](SpatialBinSet& sum, const auto& chunk) { sum.add(build_.mesh, chunk, binning); });
        return bins.find_split(binning, range.capacity());
    }

    /// No border where one half would be empty.
    template <typename Rule>
    static Split move(const SpacedRange& range, const Arrays& arrays, const Rule& rule) {
        const Division division = move_references(range, arrays.current, arrays.next, rule);
        if (division.counts[0] == 0 || division.counts[1] == 0) return {};
        const std::array<SpacedRange, 2> ranges = division.ranges(range);
        return {ranges[1].begin, ranges, division.halves, arrays.of_halves()};
    }

    /// Two halves in the order of ids, where nothing tells references apart.
    static Split halve(const SpacedRange& range, const Arrays& arrays) {
        const std::span<Reference> references(arrays.current + range.first, range.count);
        if (!std::ranges::is_sorted(references, {}, &Reference::primitive)) {
            std::ranges::sort(references, {}, &Reference::primitive);
        }
        const std::uint32_t half = range.count / 2;
        const std::uint32_t border = range.first + half;
        Split split{border,
                    {{{range.begin, border, range.first, half}, {border, range.end, border, range.count - half}}},
                    {},
                    arrays};
        split.halves[0].add(references.first(half));
        split.halves[1].add(references.subspan(half));
        return split;
    }

    HostBuild& build_;
    SbvhConfig config_;
    std::uint32_t capacity_;
    RangeTree tree_;
    float least_overlap_ = 0.0f;
};

void check(const SbvhConfig& config) {
    check_field("bin_count", config.bin_count, kBinCounts);
    check_field("spatial_bin_count", config.spatial_bin_count, kBinCounts);
    check_field("alpha", config.alpha, kSplitAlphas);
    check_field("overlap", config.overlap, kSplitOverlaps);
    check_field("reference_budget", config.reference_budget, kReferenceBudgets);
    check_positive("inner_cost", config.inner_cost);
    check_positive("primitive_cost", config.primitive_cost);
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
}

}  // namespace

void build_sbvh(HostBuild& build, const SbvhConfig& config) {
    SbvhBuilder(build, config).run();
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_sbvh(const Primitives& primitives, const SbvhConfig& config) {
    host::check(config);
    return host::build_over(primitives, [&](host::HostBuild& build) { host::build_sbvh(build, config); });
}

}  // namespace clbvh
