// BuildTree and CombineClusters, Gu et al. 2013, algorithms 3 and 4, in terms of the vectors of core/simd. Files that
// are compiled for different instruction sets include it within an anonymous namespace, so that none calls another's
// copy.
//
// Clusters are named by their place on the stack. Ties between equal distances go to the next cluster in cyclic order,
// so that equal boxes are merged in pairs, and pairs of pairs, not into a chain.

/// The distance where there is no other cluster.
constexpr float kFar = std::numeric_limits<float>::infinity();

/// Ranges of this size ask for all that they read at once.
constexpr std::uint32_t kFetch = 64;

/// Sibling pairs are asked for so many before they are written.
constexpr std::uint32_t kPairsAhead = 16;

/// The box of one cluster, in every lane.
template <typename Floats>
struct Box {
    Floats lower[3];
    Floats upper[3];

    Box(const Stack& stack, std::uint32_t cluster) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = Floats::filled(stack.bounds[axis][cluster]);
            upper[axis] = Floats::filled(stack.bounds[axis + 3][cluster]);
        }
    }
    /// Half areas of the boxes around this one and those of clusters `first` and following.
    [[nodiscard]] Floats distances(const Stack& stack, std::uint32_t first) const noexcept {
        Floats extent[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            extent[axis] = max(upper[axis], Floats::load(stack.bounds[axis + 3] + first)) -
                           min(lower[axis], Floats::load(stack.bounds[axis] + first));
        }
        return extent[0] * (extent[1] + extent[2]) + extent[1] * extent[2];
    }
};

/// `SmallSet` is a class as that of aac_small_set.ipp, or void.
template <typename Set, typename SmallSet>
class Clustering {
    using Floats = typename Set::Widest;
    using Mask = typename Floats::Mask;

public:
    /// Sibling pairs are taken from `next_pair` down; 0: from the clusters.
    Clustering(const Problem& problem, Stack& stack, std::uint32_t next_pair) noexcept
        : problem_(problem), stack_(stack), next_pair_(next_pair) {}

    /// Puts the clusters of positions begin .. end onto the stack, from `base` on. Returns their end.
    std::uint32_t build_tree(std::uint32_t begin, std::uint32_t end, std::uint32_t base, bool fetched) noexcept {
        const std::uint32_t count = end - begin;
        if (!fetched && count <= kFetch) {
            fetch(begin, end);
            fetched = true;
        }
        if (count < problem_.options.delta) {
            return build_leaf(begin, end, base, problem_.reduction(problem_.options.delta));
        }
        const std::uint32_t split = partition(problem_.codes, begin, end);
        const bool left_first = goes_left_first(begin, split, end);
        const std::uint32_t middle =
            left_first ? build_tree(begin, split, base, fetched) : build_tree(split, end, base, fetched);
        const std::uint32_t top =
            left_first ? build_tree(split, end, middle, fetched) : build_tree(begin, split, middle, fetched);
        return unite(base, middle, top, problem_.reduction(count));
    }

    /// Makes one range of two, and at most `target` clusters of it. Returns its end.
    std::uint32_t unite(std::uint32_t base, std::uint32_t middle, std::uint32_t top, std::uint32_t target) noexcept {
        if constexpr (!std::is_void_v<SmallSet>) {
            if (top - base <= SmallSet::kMostClusters) {
                SmallSet set(stack_, base, top);
                set.find_across(stack_, base, middle - base);
                return combine_small(set, base, target);
            }
        }
        find_across(base, middle, middle, top);
        find_across(middle, top, base, middle);
        return combine(base, top, target);
    }

    /// The paper's CombineClusters: merges the closest pair of base .. top until at most `target` clusters are left.
    std::uint32_t combine(std::uint32_t base, std::uint32_t top, std::uint32_t target) noexcept {
        std::uint32_t last = top;  // where the merge before took place
        while (top - base > target) {
            const std::uint32_t cluster = find_closest_pair(base, top, last);
            last = merge(cluster, stack_.closest[cluster], base, top);
            --top;
        }
        return top;
    }

private:
    void fetch(std::uint32_t begin, std::uint32_t end) const noexcept {
        for (std::uint32_t position = begin; position < end; ++position) {
            prefetch(problem_.references + problem_.ids[position]);
        }
    }

    std::uint32_t build_leaf(std::uint32_t begin, std::uint32_t end, std::uint32_t base,
                             std::uint32_t target) noexcept {
        const std::uint32_t top = base + (end - begin);
        for (std::uint32_t i = base; i < top; ++i)
            push_primitive(begin + (i - base), i);
        if constexpr (!std::is_void_v<SmallSet>) {
            if (top - base <= SmallSet::kMostClusters) {
                SmallSet set(stack_.clusters + base, top - base);
                return combine_small(set, base, target);
            }
        }
        for (std::uint32_t i = base; i < top; ++i)
            set_bounds(i, box_of(stack_.clusters[i].node));
        if (top - base == 1) {
            stack_.best[base] = kFar;
        } else {
            for (std::uint32_t i = base; i < top; ++i)
                find_best_match(i, base, top, stack_.own_distances);
        }
        return combine(base, top, target);
    }

    /// As combine().
    template <typename Small>
    std::uint32_t combine_small(Small& set, std::uint32_t base, std::uint32_t target) noexcept {
        std::uint32_t last = set.count();
        while (set.count() > target) {
            const typename Small::Pair pair = set.find_closest_pair(last);
            const std::uint32_t high = base + pair.high_lane();
            merge_clusters(base + pair.low_lane(), high, pair.area());
            stack_.clusters[high] = stack_.clusters[base + set.count() - 1];
            set.merge(pair);
            last = pair.high_lane();
        }
        set.store(stack_, base);
        return base + set.count();
    }

    void push_primitive(std::uint32_t position, std::uint32_t target) noexcept {
        const Reference& reference = problem_.references[problem_.ids[position]];
        problem_.ids[position] = reference.primitive;
        const Box4 box = Box4::of(reference);
        Cluster& cluster = stack_.clusters[target];
        cluster.node = make_node(box, position, 1);
        cluster.position = position;
        cluster.pairs = 0;
        cluster.primitives = 1;
        cluster.area = box.half_area();
        cluster.cost = problem_.options.primitive_cost;
        cluster.pair = 0;
        cluster.first_id = position;
        cluster.last_id = position;
    }

    [[nodiscard]] static Box4 box_of(const Node& node) noexcept {
        return {Float4::load(node.lower), Float4::load(node.upper)};
    }

    void set_bounds(std::uint32_t cluster, const Box4& box) noexcept {
        const Float4 corners[2] = {box.lower, box.upper};
        for (std::size_t corner = 0; corner < 2; ++corner) {
            stack_.bounds[3 * corner][cluster] = corners[corner].x();
            stack_.bounds[3 * corner + 1][cluster] = corners[corner].y();
            stack_.bounds[3 * corner + 2][cluster] = corners[corner].z();
        }
    }

    /// Measures the distances of `cluster` to all others of its range, into `distances`, and finds its closest.
    void find_best_match(std::uint32_t cluster, std::uint32_t base, std::uint32_t top, float* distances) noexcept {
        const Box<Floats> box(stack_, cluster);
        Floats least = Floats::filled(kFar);
        for (std::uint32_t j = base; j < top; j += Floats::kCount) {
            Floats distance = box.distances(stack_, j);
            distance = select(Floats::only_lane(cluster - j), Floats::filled(kFar), distance);
            distance.store(distances + j);
            least = min(least, select(Floats::first_lanes(top - j), distance, Floats::filled(kFar)));
        }
        stack_.best[cluster] = least.least();
        stack_.closest[cluster] = find_next(distances, stack_.best[cluster], base, top, cluster);
    }

    [[nodiscard]] static float find_least(const float* values, std::uint32_t base, std::uint32_t top) noexcept {
        Floats least = Floats::filled(kFar);
        for (std::uint32_t j = base; j < top; j += Floats::kCount)
            least = min(least, select(Floats::first_lanes(top - j), Floats::load(values + j), Floats::filled(kFar)));
        return least.least();
    }

    /// The first place behind `before` where `value` stands, or else the first from `base` on.
    [[nodiscard]] static std::uint32_t find_next(const float* values, float value, std::uint32_t base,
                                                 std::uint32_t top, std::uint32_t before) noexcept {
        std::uint32_t first = top;
        for (std::uint32_t j = base; j < top; j += Floats::kCount) {
            const std::uint32_t bits =
                (equal(Floats::load(values + j), Floats::filled(value)).bits()) & low_bits(top - j);
            const std::uint32_t behind = before < j ? bits : bits & ~low_bits(before - j + 1);
            if (behind != 0) return j + static_cast<std::uint32_t>(std::countr_zero(behind));
            if (bits != 0 && first == top) first = j + static_cast<std::uint32_t>(std::countr_zero(bits));
        }
        return first;
    }

    [[nodiscard]] static std::uint32_t low_bits(std::uint32_t count) noexcept {
        return count < Floats::kCount ? (1u << count) - 1 : ~0u;
    }

    [[nodiscard]] std::uint32_t find_closest_pair(std::uint32_t base, std::uint32_t top,
                                                  std::uint32_t last) const noexcept {
        return find_next(stack_.best, find_least(stack_.best, base, top), base, top, last);
    }

    /// Lets the clusters of base .. top look for closer ones among those of other_base .. other_top.
    void find_across(std::uint32_t base, std::uint32_t top, std::uint32_t other_base,
                     std::uint32_t other_top) noexcept {
        for (std::uint32_t j = base; j < top; j += Floats::kCount) {
            const Stack& stack = stack_;
            Floats best = Floats::load(stack.best + j);
            Floats closest = Floats::load(reinterpret_cast<const float*>(stack.closest) + j);
            for (std::uint32_t i = other_base; i < other_top; ++i) {
                const Floats distance = Box<Floats>(stack, i).distances(stack, j);
                const Mask closer = less(distance, best);
                best = min(distance, best);
                closest = select(closer, Floats::filled_with_bits(i), closest);
            }
            best.store_first(top - j, stack.best + j);
            closest.store_first(top - j, reinterpret_cast<float*>(stack.closest) + j);
        }
    }

    /// Merges two clusters of base .. top into the place of one, and moves the last cluster to that of the other.
    /// Returns the larger of the two places.
    std::uint32_t merge(std::uint32_t a, std::uint32_t b, std::uint32_t base, std::uint32_t top) noexcept {
        const std::uint32_t low = std::min(a, b);
        const std::uint32_t high = std::max(a, b);
        const std::uint32_t last = top - 1;
        set_bounds(low, merge_clusters(low, high, stack_.best[a]));
        if (high != last) move(last, high);
        find_best_match(low, base, last, stack_.merged_distances);
        update_closest(low, high, base, last);
        return high;
    }

    /// Makes the parent of both of `low`, and returns its box. The one that begins first is its left child. Where a
    /// leaf is cheaper, there is no sibling pair to write: the primitives of small clusters are chained, whether they
    /// are leaves yet or not.
    Box4 merge_clusters(std::uint32_t low, std::uint32_t high, float area) noexcept {
        Cluster& merged = stack_.clusters[low];
        const bool in_order = merged.position < stack_.clusters[high].position;
        const Cluster& left = stack_.clusters[in_order ? low : high];
        const Cluster& right = stack_.clusters[in_order ? high : low];
        Box4 box = box_of(left.node);
        box.merge(box_of(right.node));
        const std::uint32_t pair = next_pair_ != 0 ? next_pair_ : std::max(left.pair, right.pair);
        const std::uint32_t primitives = left.primitives + right.primitives;
        const std::uint32_t first_id = left.first_id;
        Node parent = make_node(box, 2 * pair, 0);
        if (primitives <= problem_.options.max_leaf_size) {
            problem_.next_ids[left.last_id] = right.first_id;
            merged.last_id = right.last_id;
            const float as_leaf = problem_.options.primitive_cost * static_cast<float>(primitives);
            const float as_inner = cost_of_inner(problem_.options.inner_cost, left, right, area);
            if (as_leaf <= as_inner) parent = make_node(box, first_id, primitives);
            merged.cost = std::min(as_leaf, as_inner);
        }
        std::uint32_t pairs = 0;
        if (!parent.is_leaf()) {
            prefetch(problem_.nodes + 2 * std::size_t{pair - std::min(pair, kPairsAhead)});
            problem_.nodes[2 * std::size_t{pair}] = left.node;
            problem_.nodes[2 * std::size_t{pair} + 1] = right.node;
            pairs = left.pairs + right.pairs + 1;
            problem_.extents[pair] = {pairs, primitives};
            if (next_pair_ != 0) --next_pair_;
        }
        merged.pair = std::min(left.pair, right.pair);
        merged.position = left.position;
        merged.pairs = pairs;
        merged.primitives = primitives;
        merged.area = area;
        merged.first_id = first_id;
        merged.node = parent;
        return box;
    }

    void move(std::uint32_t from, std::uint32_t to) noexcept {
        stack_.clusters[to] = stack_.clusters[from];
        for (float* const bound : stack_.bounds)
            bound[to] = bound[from];
        stack_.best[to] = stack_.best[from];
        stack_.closest[to] = stack_.closest[from];
    }

    /// Clusters whose closest was merged look for another one; those whose closest was moved follow it.
    void update_closest(std::uint32_t low, std::uint32_t high, std::uint32_t base, std::uint32_t top) noexcept {
        float* const closest_lanes = reinterpret_cast<float*>(stack_.closest);
        for (std::uint32_t j = base; j < top; j += Floats::kCount) {
            const Floats closest = Floats::load(closest_lanes + j);
            const Mask lost =
                same_bits(closest, Floats::filled_with_bits(low)) | same_bits(closest, Floats::filled_with_bits(high));
            const Mask moved = same_bits(closest, Floats::filled_with_bits(top));
            select(moved, Floats::filled_with_bits(high), closest).store(closest_lanes + j);
            std::uint32_t bits = lost.bits() & low_bits(top - j);
            for (; bits != 0; bits &= bits - 1)
                replace_closest(j + static_cast<std::uint32_t>(std::countr_zero(bits)), low, base, top);
        }
    }

    /// The merged cluster is no closer than its parts were; where it is as close, there is nothing to look for.
    void replace_closest(std::uint32_t cluster, std::uint32_t merged, std::uint32_t base, std::uint32_t top) noexcept {
        if (cluster == merged) return;
        if (stack_.merged_distances[cluster] == stack_.best[cluster]) {
            stack_.closest[cluster] = merged;
        } else {
            find_best_match(cluster, base, top, stack_.own_distances);
        }
    }

    const Problem& problem_;
    Stack& stack_;
    std::uint32_t next_pair_;
};

template <typename Set, typename SmallSet>
std::uint32_t build_tree(const Problem& problem, Stack& stack, std::uint32_t begin, std::uint32_t end,
                         std::uint32_t most) noexcept {
    Clustering<Set, SmallSet> clustering(problem, stack, end - 1);
    const std::uint32_t top = clustering.combine(0, clustering.build_tree(begin, end, 0, false), most);
    for (std::uint32_t i = 0; i < top; ++i)
        stack.clusters[i].pair = begin + i;
    return top;
}

template <typename Set, typename SmallSet>
std::uint32_t unite(const Problem& problem, Stack& stack, std::uint32_t middle, std::uint32_t top,
                    std::uint32_t target) noexcept {
    Clustering<Set, SmallSet> clustering(problem, stack, 0);
    return clustering.unite(0, middle, top, target);
}

template <typename Set, typename SmallSet>
Clusterer clusterer_of() noexcept {
    return {build_tree<Set, SmallSet>, unite<Set, SmallSet>};
}
