#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/simd/always_inline.hpp"
#include "host/build/emit_tree.hpp"
#include "host/build/reference.hpp"

namespace clbvh::host::aac {

/// f(n) = constant * n^exponent, but at least 1 and at most n: the most clusters that n primitives are reduced to
/// before they meet others. The paper does not say how it rounds; to the nearest gave the best trees.
class Reduction {
public:
    Reduction(double constant, double exponent) noexcept : constant_(constant), exponent_(exponent) {}

    /// Gu et al. 2013, section 3.2: f(delta) = delta / 2.
    [[nodiscard]] static Reduction of_paper(std::uint32_t delta, double epsilon) noexcept {
        return {std::pow(delta, 0.5 + epsilon) / 2, 0.5 - epsilon};
    }
    /// f(n) = n: all clusters meet at the root, and the tree is that of greedy agglomerative clustering.
    [[nodiscard]] static Reduction none() noexcept { return {1.0, 1.0}; }

    [[nodiscard]] std::uint32_t operator()(std::size_t count) const noexcept {
        const double clusters = std::round(constant_ * std::pow(static_cast<double>(count), exponent_));
        return static_cast<std::uint32_t>(std::clamp(clusters, 1.0, static_cast<double>(count)));
    }

private:
    double constant_;
    double exponent_;
};

/// A Reduction looked up: small arguments come up with every few primitives.
class ReductionTable {
public:
    ReductionTable(const Reduction& reduction, std::size_t most) : values_(most + 1, 1) {
        fill(reduction, 1, most, reduction(1), reduction(most));
    }

    [[nodiscard]] std::uint32_t operator()(std::size_t count) const noexcept { return values_[count]; }

private:
    /// f never falls: between equal values there is nothing to compute.
    void fill(const Reduction& reduction, std::size_t first, std::size_t last, std::uint32_t at_first,
              std::uint32_t at_last) {
        if (at_first == at_last || last - first < 2) {
            std::fill(values_.begin() + static_cast<std::ptrdiff_t>(first),
                      values_.begin() + static_cast<std::ptrdiff_t>(last), at_first);
            values_[last] = at_last;
            return;
        }
        const std::size_t middle = first + (last - first) / 2;
        const std::uint32_t at_middle = reduction(middle);
        fill(reduction, first, middle, at_first, at_middle);
        fill(reduction, middle, last, at_middle, at_last);
    }

    std::vector<std::uint32_t> values_;
};

/// A subtree that is not yet part of a larger one.
struct alignas(64) Cluster {
    Node node;                 ///< Its root, which stands nowhere yet.
    std::uint32_t position;    ///< Smallest position in Morton order of its primitives.
    std::uint32_t pairs;       ///< See Extent.
    std::uint32_t primitives;  ///< See Extent.
    float area;                ///< Half area of its box.
    float cost;                ///< C(T) of section 3.3.2, as long as it may become a leaf.
    std::uint32_t first_id;    ///< Where the chain of its primitives begins, as long as it may become a leaf.
    std::uint32_t last_id;     ///< Where that ends.
    std::uint32_t pair;        ///< A sibling pair that is free, one for each cluster that a task has left.
};
static_assert(sizeof(Cluster) == 64);

/// Those of AacConfig that the clustering reads.
struct Options {
    std::uint32_t delta;
    float inner_cost;
    float primitive_cost;
    std::uint32_t max_leaf_size;
};

/// Section 3.3.2: C(T) of an inner node with these children, whose half area is `area`. Where that is 0, a ray that
/// meets the node meets both children.
[[nodiscard]] CLBVH_ALWAYS_INLINE float cost_of_inner(float inner_cost, const Cluster& left, const Cluster& right,
                                                      float area) noexcept {
    const float left_cost = inner_cost + left.cost;
    const float right_cost = inner_cost + right.cost;
    return area > 0.0f ? (left.area * left_cost + right.area * right_cost) / area : left_cost + right_cost;
}

/// The primitives in Morton order, and where the tree goes.
struct Problem {
    Options options;
    const ReductionTable& reduction;  ///< Up to the size of the largest task.
    const std::uint64_t* codes;       ///< In ascending order.
    std::uint32_t* ids;       ///< For each position, the reference that stands there; once that is a cluster, its id.
    std::uint32_t* next_ids;  ///< For each position, the next one of the same leaf.
    const Reference* references;  ///< In the order that they came in.
    Node* nodes;      ///< Pair p is nodes 2p and 2p + 1; a task over positions b .. e takes those from e - 1
                      ///< down, and the clusters that it leaves get those from b up.
    Extent* extents;  ///< See TreeSlots.
};

/// MakePartition of section 3.1: where the highest bit that is not the same in all codes of begin .. end, two at least,
/// becomes 1; or the middle, where all codes are equal.
[[nodiscard]] CLBVH_ALWAYS_INLINE std::uint32_t partition(const std::uint64_t* codes, std::uint32_t begin,
                                                          std::uint32_t end) noexcept {
    const std::uint64_t last = codes[end - 1];
    const std::uint64_t difference = codes[begin] ^ last;
    if (difference == 0) return begin + (end - begin) / 2;
    const std::uint64_t first_right = last & ~(std::bit_floor(difference) - 1);
    std::uint32_t split = begin;
    for (std::uint32_t left = end - begin; left > 0;) {
        const std::uint32_t half = left / 2;
        const bool below = codes[split + half] < first_right;
        split = below ? split + half + 1 : split;
        left = below ? left - half - 1 : half;
    }
    return split;
}

/// Ranges of up to this size leave few clusters in whatever order their parts are built.
inline constexpr std::uint32_t kSmallRange = 64;

/// Which part of begin .. end leaves its clusters below those of the other one: of large ranges the larger part, so
/// that what lies on the stack sums up to f(n) + f(n / 2) + f(n / 4) + ... at most, whatever the input.
[[nodiscard]] CLBVH_ALWAYS_INLINE bool goes_left_first(std::uint32_t begin, std::uint32_t split,
                                                       std::uint32_t end) noexcept {
    return end - begin <= kSmallRange || split - begin >= end - split;
}

/// The work space of one thread: a stack of clusters, one array per property, and the distances between them.
/// A subtree leaves its clusters at the top of the stack; so the clusters of both children are one range, and the
/// distances within each child are where the parent looks for them (the paper's figure 2).
struct Stack {
    std::size_t capacity = 0;
    float* bounds[6] = {};             ///< Lower x, y, z, upper x, y, z.
    float* best = nullptr;             ///< Distance to the closest cluster of the same range; infinite without one.
    std::uint32_t* closest = nullptr;  ///< Which that is.
    Cluster* clusters = nullptr;
    float* merged_distances = nullptr;  ///< Of the cluster that was merged last, to each other one.
    float* own_distances = nullptr;     ///< Of a cluster that looks for its closest.
};

/// Clusters beyond the end of the stack that vectors may touch.
inline constexpr std::size_t kStackPadding = 16;

}  // namespace clbvh::host::aac
