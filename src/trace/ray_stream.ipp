// Tracing many rays that have nothing in common, for AVX2: some dozens are under way at a time, and take a step each in
// their turn: through a node, or through one block of triangles. The steps of different rays do not wait for each
// other, what a ray needs is asked for a turn ahead, and no step but that to a hit has a branch: so hardly anything is
// guessed wrong. A turn is a few loops over all rays rather than one: short chains of instructions, of many rays, fill
// a processor that long ones leave waiting. In terms of stream_rays.ipp.

/// Puts the greatest one first: Batcher's bitonic network.
inline simd::avx2::Int8 sorted_downwards(simd::avx2::Int8 keys) noexcept {
    const auto exchange = [&keys]<int kLesser>(__m256i partners, std::integral_constant<int, kLesser>) {
        keys.lanes =
            _mm256_blend_epi32(_mm256_max_epi32(keys.lanes, partners), _mm256_min_epi32(keys.lanes, partners), kLesser);
    };
    constexpr std::integral_constant<int, 0b10101010> odd_ones;
    constexpr std::integral_constant<int, 0b11001100> upper_pairs;
    constexpr std::integral_constant<int, 0b11110000> upper_half;
    constexpr int next = 0b10110001, mirrored = 0b00011011, next_pair = 0b01001110;
    exchange(_mm256_shuffle_epi32(keys.lanes, next), odd_ones);
    exchange(_mm256_shuffle_epi32(keys.lanes, mirrored), upper_pairs);
    exchange(_mm256_shuffle_epi32(keys.lanes, next), odd_ones);
    exchange(_mm256_permutevar8x32_epi32(keys.lanes, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0)), upper_half);
    exchange(_mm256_shuffle_epi32(keys.lanes, next_pair), upper_pairs);
    exchange(_mm256_shuffle_epi32(keys.lanes, next), odd_ones);
    return keys;
}

/// The stacks of the rays under way. Beside each child stands where the ray enters it, rounded down by some of the last
/// bits. Eight children at a time may be read or written below and above what there is: at the bottom stand eight that
/// are none, which any ray reaches.
class StreamStacks {
public:
    static constexpr std::uint32_t kFloor = kWidth;

    /// Of up to `most` rays: fewer through trees of an unusual depth.
    StreamStacks(std::uint32_t depth, std::uint32_t most)
        : room_(depth * (kWidth - 1) + 1 + kFloor + kWidth),
          count_(std::clamp(kMostEntries / room_, 1U, most)),
          memory_(allocate_stack(std::size_t{room_} * count_)),
          children_(reinterpret_cast<std::uint32_t*>(memory_.get())),
          entries_(children_ + std::size_t{room_} * count_) {
        for (std::uint32_t i = 0; i < count_; ++i) {
            std::fill_n(children_ + bottom(i) - kFloor, kFloor, WideChild::kNone);
            std::fill_n(entries_ + bottom(i) - kFloor, kFloor, 0);
        }
    }

    [[nodiscard]] std::uint32_t count() const noexcept { return count_; }
    [[nodiscard]] std::uint32_t bottom(std::uint32_t stack) const noexcept { return room_ * stack + kFloor; }
    [[nodiscard]] std::uint32_t* children() const noexcept { return children_; }
    [[nodiscard]] std::uint32_t* entries() const noexcept { return entries_; }

private:
    static constexpr std::uint32_t kMostEntries = 1U << 20U;

    std::uint32_t room_, count_;
    std::unique_ptr<std::uint64_t[]> memory_;
    std::uint32_t* children_;
    std::uint32_t* entries_;
};

/// Traces rays: eight that lie close together as one, others as a stream.
template <typename Set, typename Visitor, typename>
class RayStream {
public:
    using Result = typename Visitor::Result;

    RayStream(const Wide8& tree, std::span<const Ray> rays, Result* results)
        : tree_(tree),
          rays_(rays),
          results_(results),
          limits_(packet_limits(tree.nodes[0])),
          packet_stack_(tree.depth),
          stacks_(tree.depth, kUnderWay) {}

    void trace_all() {
        for (std::uint32_t slot = 0; slot < stacks_.count(); ++slot)
            start(under_way_[slot]);
        while (counts_.at_node + counts_.at_leaf != 0) {
            visit_nodes();
            visit_leaves();
            for (StreamRay* const ray : done_.first(std::exchange(counts_.done, 0))) {
                finish(*ray);
                start(*ray);
            }
        }
    }

private:
    using Floats4 = typename Set::Float4;
    using Floats8 = typename Set::Float8;
    using Int8 = simd::avx2::Int8;
    using Test = typename Visitor::TriangleTestOfRays;
    static constexpr bool kIsAny = Visitor::kIsAny;
    static constexpr std::uint32_t kUnderWay = 32;  // 16 and 64 are no faster

    /// Rays that have something in common. What is added may go where those were that have been looked at.
    struct RayList {
        std::array<StreamRay*, kUnderWay + 1> rays;

        [[nodiscard]] std::span<StreamRay* const> first(std::uint32_t count) const noexcept {
            return {rays.data(), count};
        }
    };
    /// How many rays are in each list. Loops work on a copy, which stays in registers: stores of theirs might change
    /// the member.
    struct Counts {
        std::uint32_t at_node = 0, at_leaf = 0, done = 0;
    };

    /// Sends the ray on its way to what it visits next. A list counts it only where that is so, without a branch.
    CLBVH_ALWAYS_INLINE void go_on(StreamRay& ray, std::uint32_t child, Counts& counts) noexcept {
        static_assert(WideChild::kNone == 0xFFFFFFFFU && WideChild::kLeafFlag == 0x80000000U);
        const auto is_none = static_cast<std::uint32_t>((std::uint64_t{child} + 1) >> 32U);
        const std::uint32_t is_no_node = child >> 31U;
        at_node_.rays[counts.at_node] = &ray;
        at_leaf_.rays[counts.at_leaf] = &ray;
        done_.rays[counts.done] = &ray;
        counts.at_node += 1 - is_no_node;
        counts.at_leaf += is_no_node - is_none;
        counts.done += is_none;
    }

    /// Puts the next ray, if there is one, into the place of one that is done.
    void start(StreamRay& place) {
        while (ready_bits_ == 0) {
            if (!get_ready()) return;
        }
        place = ready_[static_cast<std::size_t>(std::countr_zero(ready_bits_))];
        place.top = stacks_.bottom(static_cast<std::uint32_t>(&place - under_way_.data()));
        ready_bits_ &= ready_bits_ - 1;
        at_node_.rays[counts_.at_node++] = &place;
    }
    void finish(const StreamRay& ray) noexcept {
        if constexpr (kIsAny)
            results_[ray.number] = ray.hit ? 1 : 0;
        else
            results_[ray.number] = ray.hit;
    }

    /// Makes the next rays ready that do not lie close together, and traces those before them. False if there are none.
    bool get_ready() {
        for (; begin_ < rays_.size(); begin_ += kPacketRays) {
            const std::size_t count = std::min(kPacketRays, rays_.size() - begin_);
            std::array<Ray, kPacketRays> last;
            const Ray* first = rays_.data() + begin_;
            if (count < kPacketRays) {
                last.fill(*first);
                std::copy_n(first, count, last.begin());
                first = last.data();
            }
            PacketRays<Floats8> loaded = load_packet<Set>(first);
            if (count == kPacketRays && trace_packet(loaded, first)) continue;
            const std::uint32_t all = (1U << count) - 1;
            ready_bits_ = make_ready(loaded, begin_, ready_) & all;
            for (std::uint32_t left = all & ~ready_bits_; left != 0; left &= left - 1)
                results_[begin_ + static_cast<std::size_t>(std::countr_zero(left))] = Result{};
            begin_ += kPacketRays;
            return true;
        }
        return false;
    }
    bool trace_packet(PacketRays<Floats8>& loaded, const Ray* first) noexcept {
        if (!find_common(loaded, limits_)) return false;
        Visitor packet(loaded, first);
        if (!walk_packet<Set>(tree_, packet, packet_stack_.entries())) return false;
        packet.store(results_ + begin_);
        return true;
    }

    /// What all rays go through, at hand. Nodes come first, then blocks.
    struct Places {
        std::array<const std::byte*, 2> begins;
        std::array<std::size_t, 2> sizes;
        std::uint32_t* children;
        std::uint32_t* entries;
    };
    /// The children of a node that a ray meets.
    struct MetChildren {
        alignas(32) std::array<std::uint32_t, kWidth> keys;
        std::uint32_t count;
    };

    [[nodiscard]] Places places() noexcept {
        return {{reinterpret_cast<const std::byte*>(tree_.nodes.data()),
                 reinterpret_cast<const std::byte*>(tree_.blocks.data())},
                {sizeof(WideNode<8>), sizeof(TriangleBlock)},
                stacks_.children(),
                stacks_.entries()};
    }

    void visit_nodes() noexcept {
        const Places at = places();
        const std::span<StreamRay* const> rays = at_node_.first(std::exchange(counts_.at_node, 0));
        for (std::size_t i = 0; i < rays.size(); ++i)
            test_boxes(at, *rays[i], met_[i]);
        Counts counts = counts_;
        for (std::size_t i = 0; i < rays.size(); ++i)
            take_next(at, *rays[i], defer_children(at, *rays[i], met_[i]), counts);
        counts_ = counts;
    }
    /// Sends the ray to the child at this place of its stack, which becomes its top.
    CLBVH_ALWAYS_INLINE void take_next(const Places& at, StreamRay& ray, std::uint32_t top, Counts& counts) noexcept {
        const std::uint32_t child = at.children[top];
        ray.top = top;
        ray.child = child;
        prefetch_ahead(at, child);
        go_on(ray, child, counts);
    }

    static CLBVH_ALWAYS_INLINE void test_boxes(const Places& places, const StreamRay& ray, MetChildren& met) noexcept {
        const std::byte* const node = places.begins[0] + std::size_t{ray.child} * sizeof(WideNode<8>);
        const auto side = [node](std::uint32_t offset) {
            return Floats8::load_aligned(reinterpret_cast<const float*>(node + offset));
        };
        Floats8 entry = Floats8::filled(ray.t_min());
        Floats8 exit = Floats8::filled(ray.reach());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Floats8 origin = Floats8::filled(ray.origin[axis]), inverse = Floats8::filled(ray.inverse[axis]);
            entry = max((side(ray.axes.near[axis]) - origin) * inverse, entry);
            exit = min((side(ray.axes.far[axis]) - origin) * inverse, exit);
        }
        const auto is_met = less_equal(entry, exit * Floats8::filled(kBoxSlack));
        // No entry is below 0, so that integers order children as entries do. The last ones, with a key below 0, are
        // those that are not met. The lane stands in the last bits.
        const Int8 order = kIsAny ? Int8::bits_of(entry) ^ Int8::filled(0x7FFFFFFFU) : Int8::bits_of(entry);
        const Int8 named = (order & Int8::filled(~(kWidth - 1))) | Int8::lane_numbers();
        select(is_met, named, Int8::filled(0xFFFFFFFFU)).store(met.keys.data());
        met.count = static_cast<std::uint32_t>(std::popcount(is_met.bits()));
    }
    /// Puts the children that are met onto the ray's stack. Returns where the one to visit next stands there.
    static CLBVH_ALWAYS_INLINE std::uint32_t defer_children(const Places& places, const StreamRay& ray,
                                                            const MetChildren& met) noexcept {
        const std::byte* const node = places.begins[0] + std::size_t{ray.child} * sizeof(WideNode<8>);
        const Int8 keys = sorted_downwards(Int8::load(met.keys.data()));
        const std::uint32_t top = ray.top;
        constexpr std::size_t children_begin = offsetof(WideNode<8>, children);
        permuted(Int8::load(reinterpret_cast<const std::uint32_t*>(node + children_begin)), keys)
            .store(places.children + top);
        if constexpr (!kIsAny) keys.store(places.entries + top);
        return top + met.count - 1;
    }
    // A compiler may drop calls of what only prefetches; it does not where it is inlined.
    static CLBVH_ALWAYS_INLINE void prefetch_ahead(const Places& places, std::uint32_t child) noexcept {
        const std::size_t kind = child >> 31U;  // no branch
        const std::byte* const begin = places.begins[kind] + WideChild::first_block(child) * places.sizes[kind];
        constexpr std::size_t lines = 4, line_bytes = 64;
        for (std::size_t line = 0; line < lines; ++line)
            prefetch(begin + line * line_bytes);
    }

    /// Goes through one block of each leaf: first all are tested, then what was found is looked at.
    void visit_leaves() {
        const std::span<StreamRay* const> rays = at_leaf_.first(std::exchange(counts_.at_leaf, 0));
        const std::uint32_t found = test_blocks(rays);
        for (const std::uint32_t i : std::span(found_).first(found))
            accept_hits(*rays[i], tested_[i / 2], i % 2);
        const Places at = places();
        Counts counts = counts_;
        for (StreamRay* const ray : rays) {
            const bool is_done = kIsAny && ray->hit;
            const bool is_last = WideChild::block_count(ray->child) == 1;
            const std::uint32_t next_block = ray->child + 1 - (1U << WideChild::kBlockCountShift);
            const std::uint32_t waiting = next_top(*ray);
            // The leaf stays on top for its next block.
            at.children[ray->top] = is_done ? WideChild::kNone : next_block;
            take_next(at, *ray, is_last && !is_done ? waiting : ray->top, counts);
        }
        counts_ = counts;
    }
    /// Returns how many of found_ are the rays that may have hits.
    std::uint32_t test_blocks(std::span<StreamRay* const> rays) noexcept {
        std::uint32_t found = 0;
        for (std::size_t i = 0; i < rays.size(); i += 2) {
            const std::size_t second = std::min(i + 1, rays.size() - 1);
            PairHits& hits = tested_[i / 2];
            test_pair<Set, Test>({*rays[i], block_of(*rays[i])}, {*rays[second], block_of(*rays[second])}, rays_, hits);
            const std::uint32_t lanes = hits.sure | hits.inexact;
            found_[found] = static_cast<std::uint32_t>(i);
            found += (lanes & kAllLanes<Floats4>) != 0 ? 1 : 0;
            found_[found] = static_cast<std::uint32_t>(i + 1);
            found += lanes >> kBlockTriangles != 0 && second != i ? 1 : 0;
        }
        return found;
    }
    [[nodiscard]] const TriangleBlock& block_of(const StreamRay& ray) const noexcept {
        return tree_.blocks.data()[WideChild::first_block(ray.child)];
    }

    void accept_hits(StreamRay& ray, const PairHits& hits, std::uint32_t which) const noexcept {
        const TriangleBlock& block = block_of(ray);
        const auto found = [&ray](const Hit& hit) {
            if (kIsAny || is_closer(hit.t, hit.primitive, ray.hit)) {
                ray.hit = hit;
                ray.reach() = hit.t;
            }
            return !kIsAny;
        };
        LaneHits<Floats4> of_block = hits.of<Floats4>(which);
        if (of_block.inexact != 0) {
            const Ray& of_span = rays_[ray.number];
            if (!visit_hits_one_by_one(block, of_block.inexact, HitRule(of_span), Test(of_span), ray.reach(), found))
                return;
        }
        visit_accepted<Floats4>(block, StreamRayInAllLanes<Floats4>(ray), of_block, found);
    }
    /// Where on its stack is what the ray visits behind this leaf: of the topmost children the first that it reaches.
    [[nodiscard]] std::uint32_t next_top(const StreamRay& ray) const noexcept {
        if constexpr (kIsAny) return ray.top - 1;
        constexpr std::uint32_t sign = 0x80000000U;  // a hit may be at -0
        const std::uint32_t reach = (std::bit_cast<std::uint32_t>(ray.reach() * kBoxSlack) & ~sign) | (kWidth - 1);
        const Int8 topmost = Int8::load(stacks_.entries() + ray.top - kWidth);
        const std::uint32_t hidden = less(Int8::filled(reach), topmost).bits();
        return ray.top - 1 - static_cast<std::uint32_t>(std::countl_one(hidden << (32 - kWidth)));
    }

    const Wide8& tree_;
    std::span<const Ray> rays_;
    Result* results_;
    PacketLimits limits_;
    WideStack packet_stack_;
    StreamStacks stacks_;
    std::size_t begin_ = 0;         // of the rays that are neither ready nor under way
    std::uint32_t ready_bits_ = 0;  // of those in ready_ which are still there
    std::array<StreamRay, kPacketRays> ready_;
    std::array<StreamRay, kUnderWay> under_way_;
    RayList at_node_, at_leaf_, done_;
    Counts counts_;
    std::array<MetChildren, kUnderWay> met_;
    std::array<PairHits, kUnderWay / 2> tested_;
    std::array<std::uint32_t, kUnderWay + 1> found_;
};
