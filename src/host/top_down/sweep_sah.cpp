// Sweep SAH. MacDonald, Booth 1990, "Heuristics for ray tracing using space subdivision", with the three presorted
// arrays of Perard-Gayot, "Building (good) BVHs", slides "Sweep SAH: Implementation Notes".
//
// An order is an array of indices of references, sorted by centroid along one axis, ties by index. A split along one
// axis parts that order as it stands; the two others are partitioned by the side of each reference, which keeps them
// sorted. Orders move between two arrays. Once a range is small its references are copied together, so that everything
// below works in the fast caches.
#include "host/top_down/sweep_sah.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "core/check_field.hpp"
#include "host/build/cost_unit.hpp"
#include "host/build/radix_sort.hpp"
#include "host/top_down/range_tree.hpp"
#include "host/top_down/sweep_search.hpp"

namespace clbvh::host {
namespace {

/// Ranges from this size on are split by two tasks, which may go on in parallel.
constexpr std::uint32_t kParallelSubtree = 2048;
/// Ranges up to this size have their references copied together.
constexpr std::uint32_t kLocalRange = 1u << 13;
/// Ranges from this size on are partitioned in parallel, in chunks of kChunk.
constexpr std::uint32_t kParallelRange = 1u << 16;
constexpr std::uint32_t kChunk = 1u << 13;

/// Unsigned integers in the order of the floats, none of which is -0.
std::uint32_t ordered_bits(float value) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    constexpr std::uint32_t sign = 1u << 31;
    return (bits & sign) != 0 ? ~bits : bits | sign;
}

using Orders = std::array<std::uint32_t*, 3>;

/// Where a range's data lies; all arrays are as long as the input.
struct Arrays {
    Orders orders;
    Orders other_orders;    ///< Where partitioned orders go.
    Reference* references;  ///< The references that orders refer to.
    std::uint8_t* sides;    ///< For each reference: 1 where it goes right.
    bool local;             ///< True where the references stand in the range's own positions.
};

/// A range of positions that becomes a subtree.
struct Job {
    std::uint32_t slot;   ///< Node of its root.
    std::uint32_t begin;  ///< First position.
    std::uint32_t end;    ///< One behind the last.
    std::uint32_t depth;  ///< Edges above its root.

    [[nodiscard]] std::uint32_t size() const noexcept { return end - begin; }
};

/// How a range was divided. Without a border it is to become a leaf.
struct Division {
    std::uint32_t border = 0;  ///< Position where the right half begins; 0: none.
    std::uint32_t axis = 0;    ///< Along which the halves are parted already.
    Box4 box;                  ///< Of the whole range.
};

/// Writes lefts from target[left] and rights from target[right] on, both in their order.
void partition(std::span<const std::uint32_t> order, const std::uint8_t* sides, std::uint32_t* target, std::size_t left,
               std::size_t right) noexcept {
    for (const std::uint32_t index : order) {
        const std::size_t side = sides[index];
        // A mask, since compilers make a branch of a choice, which no processor can predict.
        target[left + ((right - left) & (std::size_t{0} - side))] = index;
        right += side;
        left += 1 - side;
    }
}

class SweepSahBuilder {
public:
    SweepSahBuilder(HostBuild& build, const SweepSahConfig& config)
        : build_(build),
          config_(config),
          tree_(build.scratch, build.references.size()),
          local_references_(build.scratch.take<Reference>(build.references.size())),
          local_sides_(build.scratch.take<std::uint8_t>(build.references.size())),
          unit_(cost_unit(build.bounds.box.half_area())) {}

    void run() {
        const auto count = static_cast<std::uint32_t>(build_.references.size());
        Scratch& scratch = build_.scratch;
        Arrays arrays{{}, {}, build_.references.data(), scratch.take<std::uint8_t>(count).data(), false};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            arrays.orders[axis] = scratch.take<std::uint32_t>(count).data();
            arrays.other_orders[axis] = scratch.take<std::uint32_t>(count).data();
        }
        build_.stages.begin("sort", 0.05, 0.2);
        sort_references(arrays);
        build_.stages.begin("build", 0.2, 0.95, count);
        build_subtree({0, 0, count, 0}, arrays);
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree(tree_.slots(), build_.result);
    }

private:
    void sort_references(Arrays& arrays) {
        const std::size_t count = build_.references.size();
        KeyedValues<std::uint32_t> sorted{build_.scratch.take<std::uint32_t>(count), {}};
        KeyedValues<std::uint32_t> other{build_.scratch.take<std::uint32_t>(count), {}};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sorted.values = {arrays.orders[axis], count};
            other.values = {arrays.other_orders[axis], count};
            write_keys(axis, sorted);
            if (radix_sort(sorted, other, 32, build_.scratch).values.data() != arrays.orders[axis]) {
                std::swap(arrays.orders[axis], arrays.other_orders[axis]);
            }
        }
    }

    void write_keys(std::size_t axis, const KeyedValues<std::uint32_t>& target) const {
        const std::span<const Reference> references = build_.references;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, references.size(), kChunk), [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                target.keys[i] = ordered_bits(references[i].lower[axis] + references[i].upper[axis]);
                target.values[i] = static_cast<std::uint32_t>(i);
            }
        });
    }

    Extent build_subtree(const Job& job, Arrays arrays) {
        if (!arrays.local && job.size() <= kLocalRange) gather(job, arrays);
        const Division division = divide(job, arrays);
        if (division.border == 0) return make_leaf(job, arrays, division.box);
        const std::uint32_t slot = RangeTree::left_child(division.border);
        const Job left{slot, job.begin, division.border, job.depth + 1};
        const Job right{slot + 1, division.border, job.end, job.depth + 1};
        partition_orders(job, division, arrays);
        Extent left_extent, right_extent;
        if (job.size() < kParallelSubtree) {
            left_extent = build_subtree(left, arrays);
            right_extent = build_subtree(right, arrays);
        } else {
            tbb::parallel_invoke([&] { left_extent = build_task(left, arrays); },
                                 [&] { right_extent = build_task(right, arrays); });
        }
        return tree_.set_inner(job.slot, division.box, division.border, left_extent, right_extent);
    }

    Extent build_task(const Job& job, const Arrays& arrays) {
        const Extent extent = build_subtree(job, arrays);
        if (job.size() < kParallelSubtree) build_.stages.advance(job.size());
        return extent;
    }

    /// Copies the range's references to its own positions, in the order along x.
    void gather(const Job& job, Arrays& arrays) const {
        Reference* const references = arrays.references;
        for (std::uint32_t i = job.begin; i < job.end; ++i) {
            std::uint32_t& index = arrays.orders[0][i];
            references[index].unused = i;
            local_references_[i] = references[index];
            index = i;
        }
        for (std::size_t axis = 1; axis < 3; ++axis) {
            for (std::uint32_t i = job.begin; i < job.end; ++i)
                arrays.orders[axis][i] = references[arrays.orders[axis][i]].unused;
        }
        arrays.references = local_references_.data();
        arrays.sides = local_sides_.data();
        arrays.local = true;
    }

    [[nodiscard]] Division divide(const Job& job, const Arrays& arrays) const {
        const bool may_be_leaf = job.size() <= config_.max_leaf_size;
        if (job.size() == 1 || job.depth >= kMaxSahDepth) {
            return {may_be_leaf ? 0 : job.begin + job.size() / 2, 0, bound(job, arrays)};
        }
        const auto& [x, y, z] = arrays.orders;
        const SweepResult result =
            find_sweep_split({arrays.references, {x + job.begin, y + job.begin, z + job.begin}, job.size(), unit_});
        if (may_be_leaf && !is_worth(result, job.size())) return {0, 0, result.box};
        return {job.begin + result.split.position, result.split.axis, result.box};
    }

    [[nodiscard]] bool is_worth(const SweepResult& result, std::uint32_t count) const {
        const float area = result.box.half_area() * unit_;
        return config_.inner_cost * area + config_.primitive_cost * result.split.cost <
               config_.primitive_cost * static_cast<float>(count) * area;
    }

    static Box4 bound(const Job& job, const Arrays& arrays) {
        Box4 box;
        for (std::uint32_t i = job.begin; i < job.end; ++i)
            box.merge(Box4::of(arrays.references[arrays.orders[0][i]]));
        return box;
    }

    /// Partitions the orders along the other two axes, and lets `arrays` name where all three now lie.
    static void partition_orders(const Job& job, const Division& division, Arrays& arrays) {
        const std::uint32_t* const parted = arrays.orders[division.axis];
        const auto mark = [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t i = begin; i < end; ++i)
                arrays.sides[parted[i]] = i >= division.border ? 1 : 0;
        };
        if (job.size() >= kParallelRange) {
            const std::uint32_t chunk_count = (job.size() + kChunk - 1) / kChunk;
            tbb::parallel_for(0u, chunk_count, [&](std::uint32_t chunk) {
                const std::uint32_t begin = job.begin + chunk * kChunk;
                mark(begin, std::min(begin + kChunk, job.end));
            });
        } else {
            mark(job.begin, job.end);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (axis == division.axis) continue;
            const std::span<const std::uint32_t> order(arrays.orders[axis] + job.begin, job.size());
            std::uint32_t* const target = arrays.other_orders[axis];
            if (job.size() >= kParallelRange) {
                partition_in_parallel(order, arrays.sides, target, job.begin, division.border);
            } else {
                partition(order, arrays.sides, target, job.begin, division.border);
            }
            std::swap(arrays.orders[axis], arrays.other_orders[axis]);
        }
    }

    static void partition_in_parallel(std::span<const std::uint32_t> order, const std::uint8_t* sides,
                                      std::uint32_t* target, std::size_t left, std::size_t right) {
        const std::size_t chunk_count = (order.size() + kChunk - 1) / kChunk;
        const auto chunk = [&](std::size_t c) {
            return order.subspan(c * kChunk, std::min<std::size_t>(kChunk, order.size() - c * kChunk));
        };
        std::vector<std::size_t> rights_before(chunk_count + 1);
        tbb::parallel_for(std::size_t{0}, chunk_count, [&](std::size_t c) {
            for (const std::uint32_t index : chunk(c))
                rights_before[c + 1] += sides[index];
        });
        for (std::size_t c = 0; c < chunk_count; ++c)
            rights_before[c + 1] += rights_before[c];
        tbb::parallel_for(std::size_t{0}, chunk_count, [&](std::size_t c) {
            partition(chunk(c), sides, target, left + (c * kChunk - rights_before[c]), right + rights_before[c]);
        });
    }

    Extent make_leaf(const Job& job, const Arrays& arrays, const Box4& box) {
        std::array<Reference, kMaxLeafSize> references;
        for (std::uint32_t i = 0; i < job.size(); ++i)
            references[i] = arrays.references[arrays.orders[0][job.begin + i]];
        return tree_.set_leaf(job.slot, box, job.begin, {references.data(), job.size()});
    }

    HostBuild& build_;
    SweepSahConfig config_;
    RangeTree tree_;
    std::span<Reference> local_references_;
    std::span<std::uint8_t> local_sides_;
    float unit_;
};

void check(const SweepSahConfig& config) {
    check_positive("inner_cost", config.inner_cost);
    check_positive("primitive_cost", config.primitive_cost);
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
}

}  // namespace

void build_sweep_sah(HostBuild& build, const SweepSahConfig& config) {
    SweepSahBuilder(build, config).run();
}

void build_sweep_sah(std::span<const Aabb> bounds, const SweepSahConfig& config, Scratch& scratch, Bvh& result) {
    check(config);
    build_over(
        bounds, [&](HostBuild& build) { build_sweep_sah(build, config); }, scratch, result);
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_sweep_sah(const Primitives& primitives, const SweepSahConfig& config) {
    host::check(config);
    return host::build_over(primitives, [&](host::HostBuild& build) { host::build_sweep_sah(build, config); });
}

}  // namespace clbvh
