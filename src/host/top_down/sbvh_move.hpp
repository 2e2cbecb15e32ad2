#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/top_down/binned_move.hpp"
#include "host/top_down/sbvh_binning.hpp"

namespace clbvh::host {

/// The references on one side of a split.
struct Half {
    Bounds bounds;
    double area = 0.0;  ///< Sum of the references' half areas.

    void add(const Reference& reference) noexcept {
        bounds.add(reference);
        area += double{Box4::of(reference).half_area()};
    }
    void add(std::span<const Reference> references) noexcept {
        for (const Reference& reference : references)
            add(reference);
    }
    void add(const Half& half) noexcept {
        bounds.add(half.bounds);
        area += half.area;
    }
};
using Halves = std::array<Half, 2>;

/// A range of references, in a range of positions that cut ones may fill. Where it is long it is worked on in parallel,
/// in chunks that do not depend on the number of threads.
struct SpacedRange {
    std::uint32_t begin;  ///< First position.
    std::uint32_t end;    ///< One behind the last.
    std::uint32_t first;  ///< Position of the first reference.
    std::uint32_t count;  ///< References.

    [[nodiscard]] std::uint32_t capacity() const noexcept { return end - begin; }
    [[nodiscard]] std::uint32_t chunk_count() const noexcept {
        return count < kParallelCount ? 1 : (count + kChunk - 1) / kChunk;
    }
    [[nodiscard]] std::span<const Reference> chunk(const Reference* references, std::uint32_t c) const noexcept {
        const std::span<const Reference> all(references + first, count);
        if (chunk_count() == 1) return all;
        return all.subspan(std::size_t{c} * kChunk, std::min(kChunk, count - c * kChunk));
    }

private:
    static constexpr std::uint32_t kParallelCount = 1u << 14;
    static constexpr std::uint32_t kChunk = 1u << 12;
};

/// Adds each chunk of `references` to `sum`, which is empty, with `add(sum, chunk)`.
template <typename Sum, typename Add>
void add_chunks(const SpacedRange& range, const Reference* references, Sum& sum, const Add& add) {
    if (range.chunk_count() == 1) return add(sum, range.chunk(references, 0));
    std::vector<Sum> parts(range.chunk_count(), sum);
    tbb::parallel_for(0u, range.chunk_count(), [&](std::uint32_t c) { add(parts[c], range.chunk(references, c)); });
    for (const Sum& part : parts)
        sum.add(part);
}

/// Where references go in an object split. A rule tells `sink.put(reference, goes_right)`, for a cut reference twice.
struct ObjectRule {
    const Binning& binning;
    BinnedSplit split;

    template <typename Sink>
    void operator()(const Reference& reference, Sink& sink) const noexcept {
        std::int32_t bins[4];
        binning.bins_of(reference, bins);
        sink.put(reference, static_cast<std::uint32_t>(bins[split.axis]) >= split.bin);
    }
};

/// Where references go in a spatial split. Those that straddle its plane are cut, or go to one side as they are.
class SpatialRule {
public:
    /// Without a mesh, boxes are cut.
    SpatialRule(const MeshView* mesh, const SpatialBinning& binning, const SpatialSplit& split) noexcept;

    template <typename Sink>
    void operator()(const Reference& reference, Sink& sink) const noexcept {
        std::int32_t first[4], last[4];
        const Box4 box = Box4::of(reference);
        binning_.bins_of(box.lower.without_w(), first);
        binning_.bins_of(box.upper.without_w(), last);
        const bool goes_left = static_cast<std::uint32_t>(first[split_.axis]) < split_.bin;
        const bool goes_right = static_cast<std::uint32_t>(last[split_.axis]) >= split_.bin;
        if (goes_left != goes_right) return sink.put(reference, goes_right);
        const Parts parts = cut(reference);
        if (parts.goes_left) sink.put(parts.left, false);
        if (parts.goes_right) sink.put(parts.right, true);
    }

private:
    struct Parts {
        bool goes_left;
        bool goes_right;
        Reference left;
        Reference right;
    };

    [[nodiscard]] Parts cut(const Reference& reference) const noexcept;

    const MeshView* mesh_;
    const SpatialBinning& binning_;
    const SpatialSplit& split_;
    float plane_;
    float left_area_;
    float right_area_;
};

/// A range of references after a split.
struct Division {
    std::array<std::uint32_t, 2> counts;
    Halves halves;

    /// The ranges of the halves: the lefts lie at the front of the positions, the rights at the back. Spare positions
    /// go to where the area is, because large references are the ones to be cut; a single reference needs none.
    [[nodiscard]] std::array<SpacedRange, 2> ranges(const SpacedRange& whole) const noexcept;
};

/// Counts the references that a rule sends to either side.
struct MoveCounter {
    std::array<std::uint32_t, 2> counts{};

    void put(const Reference&, bool goes_right) noexcept { ++counts[goes_right ? 1 : 0]; }
};

/// Writes lefts ascending and rights descending, without a branch on the side.
struct MoveWriter {
    Reference* left;
    Reference* right;
    Halves halves{};

    void put(const Reference& reference, bool goes_right) noexcept {
        halves[goes_right ? 1 : 0].add(reference);
        right -= goes_right ? 1 : 0;
        *(goes_right ? right : left) = reference;
        left += goes_right ? 0 : 1;
    }
};

/// How many references the rule sends to either side from the chunks before each one, and from all of them.
template <typename Rule>
std::vector<MoveCounter> count_before_chunks(const SpacedRange& range, const Reference* from, const Rule& rule) {
    std::vector<MoveCounter> before(range.chunk_count() + 1);
    tbb::parallel_for(0u, range.chunk_count(), [&](std::uint32_t c) {
        for (const Reference& reference : range.chunk(from, c))
            rule(reference, before[c + 1]);
    });
    for (std::size_t c = 1; c < before.size(); ++c) {
        before[c].counts[0] += before[c - 1].counts[0];
        before[c].counts[1] += before[c - 1].counts[1];
    }
    return before;
}

/// Copies the references of `range` from one array to the other, to the side that `rule` says.
template <typename Rule>
Division move_references(const SpacedRange& range, const Reference* from, Reference* to, const Rule& rule) {
    const std::uint32_t chunk_count = range.chunk_count();
    std::vector<MoveCounter> before(1);
    if (chunk_count > 1) before = count_before_chunks(range, from, rule);
    const auto move_chunk = [&](std::uint32_t c) {
        MoveWriter writer{to + range.begin + before[c].counts[0], to + range.end - before[c].counts[1]};
        for (const Reference& reference : range.chunk(from, c))
            rule(reference, writer);
        return writer;
    };
    if (chunk_count == 1) {
        const MoveWriter writer = move_chunk(0);
        return {{static_cast<std::uint32_t>(writer.left - (to + range.begin)),
                 static_cast<std::uint32_t>(to + range.end - writer.right)},
                writer.halves};
    }
    std::vector<Halves> parts(chunk_count);
    tbb::parallel_for(0u, chunk_count, [&](std::uint32_t c) { parts[c] = move_chunk(c).halves; });
    Division division{before.back().counts, {}};
    for (const Halves& part : parts) {
        division.halves[0].add(part[0]);
        division.halves[1].add(part[1]);
    }
    return division;
}

}  // namespace clbvh::host
