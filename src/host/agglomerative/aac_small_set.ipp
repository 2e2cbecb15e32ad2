// As many clusters as a vector of AVX2 has lanes, clustered without leaving the registers: most of the work of a build
// is in sets of that size, where stores of single lanes, and loads of vectors that wait for them, take most of the
// time. aac_clustering.cpp includes this file between aac_lanes.ipp and aac_clustering.ipp.

class SmallSet {
public:
    static constexpr std::uint32_t kMostClusters = Floats::kCount;

    /// The clusters of `base` .. `top`, with their closest ones.
    SmallSet(const Stack& stack, std::uint32_t base, std::uint32_t top) noexcept : count_(top - base) {
        for (std::size_t i = 0; i < 6; ++i)
            bounds_[i] = Floats::load(stack.bounds[i] + base);
        best_ = select(valid(), Floats::load(stack.best + base), far());
        const auto* const closest = reinterpret_cast<const Integers*>(stack.closest + base);
        closest_ = _mm256_sub_epi32(_mm256_loadu_si256(closest), filled(base));
    }

    /// Up to kMostClusters primitives of their own, measured.
    SmallSet(const Cluster* primitives, std::uint32_t count) noexcept : count_(count) {
        load_bounds(primitives);
        best_ = far();
        closest_ = _mm256_setzero_si256();
        for (std::uint32_t offset = 1; offset < count; ++offset) {
            const Integers unwrapped = _mm256_add_epi32(lane_numbers(), filled(offset));
            const Integers beyond = _mm256_cmpgt_epi32(unwrapped, filled(count - 1));
            const Integers other = _mm256_sub_epi32(unwrapped, _mm256_and_si256(beyond, filled(count)));
            Floats others[6];
            for (std::size_t i = 0; i < 6; ++i)
                others[i] = permute(bounds_[i], other);
            accept_closer(distances(others), valid(), other);
        }
    }

    void store(const Stack& stack, std::uint32_t base) const noexcept {
        for (std::size_t i = 0; i < 6; ++i)
            bounds_[i].store(stack.bounds[i] + base);
        best_.store(stack.best + base);
        _mm256_storeu_si256(reinterpret_cast<Integers*>(stack.closest + base),
                            _mm256_add_epi32(closest_, filled(base)));
    }

    [[nodiscard]] std::uint32_t count() const noexcept { return count_; }

    /// Lets the clusters before and from `middle` on look for closer ones on the other side.
    void find_across(const Stack& stack, std::uint32_t base, std::uint32_t middle) noexcept {
        const Mask left = first_lanes(middle);
        const Mask right = except(valid(), left);
        for (std::uint32_t i = 0; i < count_; ++i) {
            Floats box[6];
            for (std::size_t bound = 0; bound < 6; ++bound)
                box[bound] = Floats::filled(stack.bounds[bound][base + i]);
            accept_closer(distances(box), i < middle ? right : left, filled(i));
        }
    }

    /// Two lanes, each in all lanes of a vector, so that the boxes need not wait for their numbers.
    struct Pair {
        Integers low;
        Integers high;
        Floats distance;

        [[nodiscard]] std::uint32_t low_lane() const noexcept { return first_number(low); }
        [[nodiscard]] std::uint32_t high_lane() const noexcept { return first_number(high); }
        [[nodiscard]] float area() const noexcept { return _mm_cvtss_f32(_mm256_castps256_ps128(distance.lanes)); }
    };

    /// The closest pair; among equals, that of the next cluster behind `last`.
    [[nodiscard]] Pair find_closest_pair(std::uint32_t last) const noexcept {
        const Floats least = least_everywhere(best_);
        const Integers a = filled(next_lane(equal(best_, least).bits(), last));
        const Integers b = _mm256_permutevar8x32_epi32(closest_, a);
        return {_mm256_min_epi32(a, b), _mm256_max_epi32(a, b), least};
    }

    /// Puts the box around both of the pair into the lane of one, and the last cluster into that of the other.
    void merge(const Pair& pair) noexcept {
        const Integers last = filled(--count_);
        const Mask is_low = same(lane_numbers(), pair.low);
        const Integers from = blend(same(lane_numbers(), pair.high), last, lane_numbers());
        Floats merged[6];
        for (std::size_t i = 0; i < 6; ++i) {
            const Floats low = permute(bounds_[i], pair.low);
            const Floats high = permute(bounds_[i], pair.high);
            merged[i] = i < 3 ? min(low, high) : max(low, high);
            bounds_[i] = select(is_low, merged[i], permute(bounds_[i], from));
        }
        best_ = select(valid(), permute(best_, from), far());
        closest_ = _mm256_permutevar8x32_epi32(closest_, from);

        const Mask others = except(valid(), is_low);
        const Floats distance = select(others, distances(merged), far());
        const Mask lost = both(same(closest_, pair.low) | same(closest_, pair.high), others);
        closest_ = blend(same(closest_, last), pair.high, closest_);
        // The merged cluster is no closer than its parts were; where it is as close, there is nothing to look for.
        const Mask kept = both(lost, equal(distance, best_));
        closest_ = blend(kept, pair.low, closest_);
        set_closest(pair.low_lane(), is_low, distance);
        for (std::uint32_t bits = except(lost, kept).bits(); bits != 0; bits &= bits - 1)
            find_best_match(static_cast<std::uint32_t>(std::countr_zero(bits)));
    }

private:
    void load_bounds(const Cluster* primitives) noexcept {
        __m128 halves[2][2][4];  // of lanes, of corners, of coordinates
        for (std::uint32_t half = 0; half < 2; ++half) {
            if (half == 1 && count_ <= 4) continue;
            for (std::uint32_t i = 0; i < 4; ++i) {
                const Node& node = primitives[std::min(4 * half + i, count_ - 1)].node;
                halves[half][0][i] = _mm_loadu_ps(node.lower);
                halves[half][1][i] = _mm_loadu_ps(node.upper);
            }
            for (auto& corner : halves[half])
                _MM_TRANSPOSE4_PS(corner[0], corner[1], corner[2], corner[3]);
        }
        for (std::size_t i = 0; i < 6; ++i) {
            const __m128 first = halves[0][i / 3][i % 3];
            bounds_[i].lanes = _mm256_set_m128(count_ <= 4 ? first : halves[1][i / 3][i % 3], first);
        }
    }

    /// Half areas of the boxes around those of `others` and the clusters', lane by lane.
    [[nodiscard]] Floats distances(const Floats (&others)[6]) const noexcept {
        const Floats x = max(others[3], bounds_[3]) - min(others[0], bounds_[0]);
        const Floats y = max(others[4], bounds_[4]) - min(others[1], bounds_[1]);
        const Floats z = max(others[5], bounds_[5]) - min(others[2], bounds_[2]);
        return x * (y + z) + y * z;
    }

    void accept_closer(Floats distance, Mask lanes, Integers other) noexcept {
        const Mask closer = both(less(distance, best_), lanes);
        best_ = select(closer, distance, best_);
        closest_ = blend(closer, other, closest_);
    }

    void find_best_match(std::uint32_t cluster) noexcept {
        const Integers lane = filled(cluster);
        const Mask is_cluster = same(lane_numbers(), lane);
        Floats box[6];
        for (std::size_t i = 0; i < 6; ++i)
            box[i] = permute(bounds_[i], lane);
        set_closest(cluster, is_cluster, select(except(valid(), is_cluster), distances(box), far()));
    }

    void set_closest(std::uint32_t cluster, Mask is_cluster, Floats distance) noexcept {
        const Floats least = least_everywhere(distance);
        best_ = select(is_cluster, least, best_);
        closest_ = blend(is_cluster, filled(next_lane(equal(distance, least).bits(), cluster)), closest_);
    }

    /// The first of `bits` behind `before`, or else the first of all. There is one.
    [[nodiscard]] static std::uint32_t next_lane(std::uint32_t bits, std::uint32_t before) noexcept {
        const std::uint32_t behind = bits & (~std::uint32_t{1} << before);
        return static_cast<std::uint32_t>(std::countr_zero(behind != 0 ? behind : bits));
    }

    [[nodiscard]] static Floats least_everywhere(Floats values) noexcept {
        const __m256 fours = _mm256_min_ps(values.lanes, _mm256_permute2f128_ps(values.lanes, values.lanes, 1));
        const __m256 twos = _mm256_min_ps(fours, _mm256_permute_ps(fours, 0x4e));
        return {_mm256_min_ps(twos, _mm256_permute_ps(twos, 0xb1))};
    }

    [[nodiscard]] Mask valid() const noexcept { return first_lanes(count_); }
    [[nodiscard]] static Floats far() noexcept { return Floats::filled(kFar); }
    [[nodiscard]] static Integers filled(std::uint32_t value) noexcept {
        return _mm256_set1_epi32(static_cast<int>(value));
    }
    [[nodiscard]] static Integers lane_numbers() noexcept { return _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7); }
    [[nodiscard]] static Mask same(Integers a, Integers b) noexcept {
        return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b))};
    }
    [[nodiscard]] static Mask both(Mask a, Mask b) noexcept { return {_mm256_and_ps(a.lanes, b.lanes)}; }
    [[nodiscard]] static Mask except(Mask a, Mask b) noexcept { return {_mm256_andnot_ps(b.lanes, a.lanes)}; }
    [[nodiscard]] static Integers blend(Mask mask, Integers a, Integers b) noexcept {
        return _mm256_blendv_epi8(b, a, _mm256_castps_si256(mask.lanes));
    }
    [[nodiscard]] static Floats permute(Floats values, Integers from) noexcept {
        return {_mm256_permutevar8x32_ps(values.lanes, from)};
    }
    [[nodiscard]] static std::uint32_t first_number(Integers values) noexcept {
        return static_cast<std::uint32_t>(_mm256_cvtsi256_si32(values));
    }

    std::uint32_t count_;
    Floats bounds_[6];  ///< As those of Stack.
    Floats best_;       ///< Infinite in lanes without a cluster.
    Integers closest_;  ///< Lanes.
};
