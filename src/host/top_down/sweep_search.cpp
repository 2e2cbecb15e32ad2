// The exact minimum of the surface area heuristic over all positions of three sorted orders, by branch and bound.
//
// A position between b and e cannot cost less than the references before b and those from e on do alone. The boxes of
// some dozens of blocks therefore rule out nearly all positions; only the blocks that may hold the minimum are swept.
// Half areas, products and sums are monotone in float32 too, so this is exact, ties included.
#include "host/top_down/sweep_search.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>
#include <vector>

namespace clbvh::host {
namespace {

/// Ranges up to this size are swept as they are; blocks are about as large at least.
constexpr std::uint32_t kSweepSize = 32;
constexpr std::uint32_t kMaxBlocks = 64;
/// Ranges from this size on are searched in parallel.
constexpr std::uint32_t kParallelRange = 1u << 16;

/// Positions begin .. end of one order, between what lies left and right of them.
struct Segment {
    std::uint32_t axis;
    std::uint32_t begin;
    std::uint32_t end;
    Box4 left;   ///< Of all references before `begin`.
    Box4 right;  ///< Of all references from `end` on.

    [[nodiscard]] std::uint32_t size() const noexcept { return end - begin; }
};

/// A box that is not initialised: small ranges use only the first few of an array of them.
struct StoredBox {
    Float4 lower;
    Float4 upper;

    StoredBox& operator=(const Box4& box) noexcept {
        lower = box.lower;
        upper = box.upper;
        return *this;
    }
    [[nodiscard]] Box4 load() const noexcept { return {lower, upper}; }
};

/// A segment cut into blocks.
class Blocks {
public:
    Blocks(const SortedRange& range, const Segment& segment) noexcept
        : range_(range),
          segment_(segment),
          count_(std::min(kMaxBlocks, (segment.size() + kSweepSize - 1) / kSweepSize)) {}

    [[nodiscard]] std::uint32_t count() const noexcept { return count_; }

    /// Finds the box of one block.
    void bound(std::uint32_t block) noexcept {
        Box4 box;
        for (std::uint32_t i = border(block); i < border(block + 1); ++i)
            box.merge(range_.box(segment_.axis, i));
        lefts_[block + 1] = box;
    }

    /// When all blocks are bounded: what lies left and right of each border, and the best of these splits.
    void sweep_borders(SweepSplit& best) noexcept {
        Box4 box = segment_.right;
        rights_[count_] = box;
        for (std::uint32_t block = count_; block-- > 0;) {
            box.merge(lefts_[block + 1].load());
            rights_[block] = box;
        }
        box = segment_.left;
        lefts_[0] = box;
        for (std::uint32_t block = 1; block < count_; ++block) {
            box.merge(lefts_[block].load());
            lefts_[block] = box;
            const std::uint32_t position = border(block);
            const SweepSplit split{
                box.half_area() * range_.weight(position) + right_area(block) * range_.weight(range_.count - position),
                segment_.axis, position};
            if (split.is_better_than(best, range_.count)) best = split;
        }
    }

    /// True where a position inside the block may be as good as `best`.
    [[nodiscard]] bool may_hold_better(std::uint32_t block, const SweepSplit& best) const noexcept {
        const std::uint32_t begin = border(block);
        const std::uint32_t end = border(block + 1);
        if (end - begin < 2) return false;
        const float left = begin == 0 ? 0.0f : lefts_[block].load().half_area() * range_.weight(begin + 1);
        const float right = end == range_.count ? 0.0f : right_area(block + 1) * range_.weight(range_.count - end + 1);
        return left + right <= best.cost;
    }

    [[nodiscard]] Segment segment(std::uint32_t block) const noexcept {
        return {segment_.axis, border(block), border(block + 1), lefts_[block].load(), rights_[block + 1].load()};
    }
    /// Of the whole segment and all right of it.
    [[nodiscard]] Box4 whole() const noexcept { return rights_[0].load(); }

private:
    [[nodiscard]] float right_area(std::uint32_t block) const noexcept { return rights_[block].load().half_area(); }
    [[nodiscard]] std::uint32_t border(std::uint32_t block) const noexcept {
        return segment_.begin + static_cast<std::uint32_t>(std::uint64_t{segment_.size()} * block / count_);
    }

    const SortedRange& range_;
    Segment segment_;
    std::uint32_t count_;
    std::array<StoredBox, kMaxBlocks + 1> lefts_;  // block b's own box stands in b + 1 until the borders are swept
    std::array<StoredBox, kMaxBlocks + 1> rights_;
};

/// Evaluates all positions inside a small segment. Returns its box, with all right of it.
Box4 sweep(const SortedRange& range, const Segment& segment, SweepSplit& best) noexcept {
    std::array<float, kSweepSize> right_costs;
    Box4 right = segment.right;
    for (std::uint32_t i = segment.size() - 1; i > 0; --i) {
        right.merge(range.box(segment.axis, segment.begin + i));
        right_costs[i] = right.half_area() * range.weight(range.count - segment.begin - i);
    }
    Box4 left = segment.left;
    for (std::uint32_t i = 1; i < segment.size(); ++i) {
        const std::uint32_t position = segment.begin + i;
        left.merge(range.box(segment.axis, position - 1));
        const float cost = left.half_area() * range.weight(position) + right_costs[i];
        if (cost > best.cost) continue;
        const SweepSplit split{cost, segment.axis, position};
        if (split.is_better_than(best, range.count)) best = split;
    }
    right.merge(range.box(segment.axis, segment.begin));
    return right;
}

void search(const SortedRange& range, const Segment& segment, SweepSplit& best) noexcept;

void search_blocks(const SortedRange& range, const Blocks& blocks, SweepSplit& best) noexcept {
    for (std::uint32_t block = 0; block < blocks.count(); ++block) {
        if (blocks.may_hold_better(block, best)) search(range, blocks.segment(block), best);
    }
}

/// Evaluates all positions inside a segment that may be better than `best`.
void search(const SortedRange& range, const Segment& segment, SweepSplit& best) noexcept {
    if (segment.size() <= kSweepSize) {
        sweep(range, segment, best);
        return;
    }
    Blocks blocks(range, segment);
    for (std::uint32_t block = 0; block < blocks.count(); ++block)
        blocks.bound(block);
    blocks.sweep_borders(best);
    search_blocks(range, blocks, best);
}

std::array<Blocks, 3> cut_along_all_axes(const SortedRange& range) noexcept {
    const auto blocks = [&](std::uint32_t axis) { return Blocks(range, {axis, 0, range.count, {}, {}}); };
    return {blocks(0), blocks(1), blocks(2)};
}

/// As the sequential search, by blocks in parallel. Every task starts from the best border, and the order of splits is
/// total: so the result is the same.
void search_in_parallel(const SortedRange& range, std::array<Blocks, 3>& axes, SweepSplit& best) {
    const std::uint32_t count = axes[0].count();
    tbb::parallel_for(0u, 3 * count, [&](std::uint32_t i) { axes[i / count].bound(i % count); });
    for (Blocks& blocks : axes)
        blocks.sweep_borders(best);
    std::vector<Segment> segments;
    for (const Blocks& blocks : axes) {
        for (std::uint32_t block = 0; block < count; ++block) {
            if (blocks.may_hold_better(block, best)) segments.push_back(blocks.segment(block));
        }
    }
    std::vector<SweepSplit> splits(segments.size(), best);
    tbb::parallel_for(std::size_t{0}, segments.size(), [&](std::size_t i) { search(range, segments[i], splits[i]); });
    for (const SweepSplit& split : splits) {
        if (split.is_better_than(best, range.count)) best = split;
    }
}

}  // namespace

SweepResult find_sweep_split(const SortedRange& range) {
    SweepResult result;
    if (range.count <= kSweepSize) {
        for (std::uint32_t axis = 0; axis < 3; ++axis)
            result.box = sweep(range, {axis, 0, range.count, {}, {}}, result.split);
        return result;
    }
    std::array<Blocks, 3> axes = cut_along_all_axes(range);
    if (range.count >= kParallelRange) {
        search_in_parallel(range, axes, result.split);
    } else {
        for (Blocks& blocks : axes) {
            for (std::uint32_t block = 0; block < blocks.count(); ++block)
                blocks.bound(block);
            blocks.sweep_borders(result.split);
        }
        for (const Blocks& blocks : axes)
            search_blocks(range, blocks, result.split);
    }
    result.box = axes[0].whole();
    return result;
}

}  // namespace clbvh::host
