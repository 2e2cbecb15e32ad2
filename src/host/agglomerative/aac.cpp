// Approximate agglomerative clustering. Gu, He, Fatahalian, Blelloch 2013, "Efficient BVH construction via approximate
// agglomerative clustering".
//
// This file orders the primitives and divides them among tasks; aac_clustering.ipp holds what a task does. Departures:
// the larger part of a range goes first, which bounds the work space for every input; see docs/builders/aac.md for all.
#include "host/agglomerative/aac.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <vector>

#include "core/check_field.hpp"
#include "core/simd/prefetch.hpp"
#include "host/agglomerative/morton.hpp"
#include "host/agglomerative/refine_codes.hpp"
#include "host/build/radix_sort.hpp"

namespace clbvh::host::aac {
namespace {

/// Ranges up to this size are built by one task, on one stack.
constexpr std::uint32_t kTask = 4096;
constexpr std::size_t kChunk = 8192;
/// References ahead of the one at work that are asked for.
constexpr std::size_t kPrefetch = 64;

/// The clusters that a subtree hands to its parent, which may be another task.
struct Clusters {
    std::vector<Cluster> clusters;
    std::vector<float> best;
    std::vector<std::uint32_t> closest;
};

/// Work spaces, one for each thread of the arena, each as large as that thread has needed so far.
class Stacks {
public:
    explicit Stacks(Scratch& scratch)
        : scratch_(scratch), stacks_(static_cast<std::size_t>(tbb::this_task_arena::max_concurrency())) {}

    /// For the calling thread, as long as it starts no tasks.
    Stack& of_this_thread(std::size_t capacity) {
        Stack& stack = stacks_[static_cast<std::size_t>(tbb::this_task_arena::current_thread_index())];
        if (stack.capacity < capacity) stack = allocate(capacity);
        return stack;
    }

private:
    Stack allocate(std::size_t capacity) {
        Stack stack;
        const std::size_t padded = capacity + kStackPadding;
        stack.capacity = capacity;
        for (float*& bound : stack.bounds)
            bound = scratch_.take<float>(padded).data();
        stack.best = scratch_.take<float>(padded).data();
        stack.closest = scratch_.take<std::uint32_t>(padded).data();
        stack.clusters = scratch_.take<Cluster>(capacity).data();
        stack.merged_distances = scratch_.take<float>(padded).data();
        stack.own_distances = scratch_.take<float>(padded).data();
        return stack;
    }

    Scratch& scratch_;
    std::vector<Stack> stacks_;
};

class AacBuilder {
public:
    AacBuilder(HostBuild& build, const AacConfig& config, const Variant& variant)
        : build_(build),
          count_(static_cast<std::uint32_t>(build.references.size())),
          bits_(morton_bits(count_)),
          cubic_cells_(config.cubic_cells),
          task_size_(std::max(kTask, config.delta)),
          reduction_(variant.reduction),
          small_reductions_(variant.reduction, task_size_),
          clusterer_(clusterer(variant.instruction_set)),
          stacks_(build.scratch),
          nodes_(build.scratch.take<Node>(2 * std::size_t{count_})),
          extents_(build.scratch.take<Extent>(count_)),
          problem_{{config.delta, config.inner_cost, config.primitive_cost, config.max_leaf_size},
                   small_reductions_,
                   nullptr,
                   nullptr,
                   build.scratch.take<std::uint32_t>(count_).data(),
                   build.references.data(),
                   nodes_.data(),
                   extents_.data()} {}

    void run() {
        build_.stages.begin("morton", 0.05, 0.10);
        const KeyedValues<std::uint64_t> codes = take_codes();
        compute_codes(codes);
        build_.stages.begin("sort", 0.10, 0.25);
        const KeyedValues<std::uint64_t> sorted = radix_sort(codes, take_codes(), 3 * bits_, build_.scratch);
        if (cubic_cells_) refine_codes(sorted, build_.references);
        problem_.codes = sorted.keys.data();
        problem_.ids = sorted.values.data();
        build_.stages.begin("cluster", 0.25, 0.95, count_);
        nodes_[0] = build_tree(0, count_, 1).clusters[0].node;
        build_.stages.begin("layout", 0.95, 1.0);
        emit_tree({nodes_, extents_, sorted.values, {problem_.next_ids, count_}}, build_.result);
    }

private:
    KeyedValues<std::uint64_t> take_codes() {
        return {build_.scratch.take<std::uint64_t>(count_), build_.scratch.take<std::uint32_t>(count_)};
    }

    void compute_codes(const KeyedValues<std::uint64_t>& codes) const {
        const tbb::blocked_range<std::size_t> all(0, count_, kChunk);
        const std::span<const Reference> references = build_.references;
        const MortonGrid grid = cubic_cells_ ? MortonGrid::cubic(build_.bounds.centroids, 3 * bits_)
                                             : MortonGrid::stretched(build_.bounds.centroids, bits_);
        tbb::parallel_for(all, [&](const auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                prefetch(references.data() + i + kPrefetch);
                codes.keys[i] = grid.code_of(references[i]);
                codes.values[i] = static_cast<std::uint32_t>(i);
            }
        });
    }

    /// Algorithm 3; leaves at most `most` clusters.
    Clusters build_tree(std::uint32_t begin, std::uint32_t end, std::uint32_t most) {
        if (end - begin <= task_size_) return build_small_tree(begin, end, most);
        const std::uint32_t split = partition(problem_.codes, begin, end);
        Clusters left, right;
        tbb::parallel_invoke([&] { left = build_tree(begin, split, count_); },
                             [&] { right = build_tree(split, end, count_); });
        // The order that a single task would have them in.
        if (!goes_left_first(begin, split, end)) std::swap(left, right);
        const auto middle = static_cast<std::uint32_t>(left.clusters.size());
        const auto top = middle + static_cast<std::uint32_t>(right.clusters.size());
        Stack& stack = stacks_.of_this_thread(top);
        put(left, stack, 0);
        put(right, stack, middle);
        return take(stack, clusterer_.unite(problem_, stack, middle, top, std::min(most, reduction_(end - begin))));
    }

    Clusters build_small_tree(std::uint32_t begin, std::uint32_t end, std::uint32_t most) {
        Stack& stack = stacks_.of_this_thread(stack_size(end - begin));
        Clusters clusters = take(stack, clusterer_.build_tree(problem_, stack, begin, end, most));
        build_.stages.advance(end - begin);
        return clusters;
    }

    /// See goes_left_first(). The paper's 4 c n^(0.5 - epsilon / 2) is enough for most inputs, this for all.
    [[nodiscard]] std::size_t stack_size(std::size_t count) const {
        std::size_t size = std::max(kSmallRange, problem_.options.delta);
        for (; count > kSmallRange; count /= 2)
            size += small_reductions_(count);
        return size;
    }

    static void put(const Clusters& from, Stack& stack, std::uint32_t base) {
        for (std::size_t i = 0; i < from.clusters.size(); ++i) {
            const std::size_t target = base + i;
            const Node& node = from.clusters[i].node;
            stack.clusters[target] = from.clusters[i];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                stack.bounds[axis][target] = node.lower[axis];
                stack.bounds[axis + 3][target] = node.upper[axis];
            }
            stack.best[target] = from.best[i];
            stack.closest[target] = base + from.closest[i];
        }
    }

    static Clusters take(const Stack& stack, std::uint32_t count) {
        return {{stack.clusters, stack.clusters + count},
                {stack.best, stack.best + count},
                {stack.closest, stack.closest + count}};
    }

    HostBuild& build_;
    std::uint32_t count_;
    std::uint32_t bits_;
    bool cubic_cells_;
    std::uint32_t task_size_;
    Reduction reduction_;
    ReductionTable small_reductions_;
    Clusterer clusterer_;
    Stacks stacks_;
    std::span<Node> nodes_;
    std::span<Extent> extents_;
    Problem problem_;
};

constexpr std::uint32_t kLeastDelta = 2;
constexpr std::uint32_t kMostDelta = 64;

void check(const AacConfig& config) {
    check_range("delta", config.delta, kLeastDelta, kMostDelta);
    check_range("epsilon", config.epsilon, 0.0f, 0.5f);
    check_positive("inner_cost", config.inner_cost);
    check_positive("primitive_cost", config.primitive_cost);
    check_range("max_leaf_size", config.max_leaf_size, 1, kMaxLeafSize);
}

}  // namespace

void build(HostBuild& build, const AacConfig& config, const Variant& variant) {
    AacBuilder(build, config, variant).run();
}

}  // namespace clbvh::host::aac

namespace clbvh::host {

void build_aac(HostBuild& build, const AacConfig& config) {
    const auto reduction = aac::Reduction::of_paper(config.delta, static_cast<double>(config.epsilon));
    aac::build(build, config, {.reduction = reduction});
}

}  // namespace clbvh::host

namespace clbvh {

Bvh build_aac(const Primitives& primitives, const AacConfig& config) {
    host::aac::check(config);
    return host::build_over(primitives, [&](host::HostBuild& build) { host::build_aac(build, config); });
}

}  // namespace clbvh
