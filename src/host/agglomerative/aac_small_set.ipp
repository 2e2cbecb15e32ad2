// As many clusters as a vector of AVX2 has lanes, clustered without leaving the registers: most of the work of a build
// is in sets of that size, where stores of single lanes, and loads of vectors that wait for them, take most of the
// time. aac_clustering_avx2.cpp includes this file within an anonymous namespace.

class SmallSet {
    using Floats = simd::avx2::Float8;
    using Integers = simd::avx2::Int8;
    using Mask = simd::avx2::Mask8;

public:
    static constexpr std::uint32_t kMostClusters = Floats::kCount;

    /// The clusters of `base` .. `top`, with their closest ones.
    SmallSet(const Stack& stack, std::uint32_t base, std::uint32_t top) noexcept : count_(top - base) {
        for (std::size_t i = 0; i < 6; ++i)
            bounds_[i] = Floats::load(stack.bounds[i] + base);
        best_ = select(valid(), Floats::load(stack.best + base), far());
        closest_ = Integers::load(stack.closest + base) - Integers::filled(base);
    }

    /// Up to kMostClusters primitives of their own, measured.
    SmallSet(const Cluster* primitives, std::uint32_t count) noexcept : count_(count) {
        load_bounds(primitives);
        best_ = far();
        closest_ = Integers::filled(0);
        for (std::uint32_t offset = 1; offset < count; ++offset) {
            const Integers other = wrapped(Integers::lane_numbers() + Integers::filled(offset), count);
            Floats others[6];
            for (std::size_t i = 0; i < 6; ++i)
                others[i] = permuted(bounds_[i], other);
            accept_closer(distances(others), valid(), other);
        }
    }

    void store(const Stack& stack, std::uint32_t base) const noexcept {
        for (std::size_t i = 0; i < 6; ++i)
            bounds_[i].store(stack.bounds[i] + base);
        best_.store(stack.best + base);
        (closest_ + Integers::filled(base)).store(stack.closest + base);
    }

    [[nodiscard]] std::uint32_t count() const noexcept { return count_; }

    /// Lets the clusters before and from `middle` on look for closer ones on the other side.
    void find_across(const Stack& stack, std::uint32_t base, std::uint32_t middle) noexcept {
        const Mask left = Floats::first_lanes(middle);
        const Mask right = except(valid(), left);
        for (std::uint32_t i = 0; i < count_; ++i) {
            Floats box[6];
            for (std::size_t bound = 0; bound < 6; ++bound)
                box[bound] = Floats::filled(stack.bounds[bound][base + i]);
            accept_closer(distances(box), i < middle ? right : left, Integers::filled(i));
        }
    }

    /// Two lanes, each in all lanes of a vector, so that the boxes need not wait for their numbers.
    struct Pair {
        Integers low;
        Integers high;
        Floats distance;

        [[nodiscard]] std::uint32_t low_lane() const noexcept { return low.first(); }
        [[nodiscard]] std::uint32_t high_lane() const noexcept { return high.first(); }
        [[nodiscard]] float area() const noexcept { return distance.x(); }
    };

    /// The closest pair; among equals, that of the next cluster behind `last`.
    [[nodiscard]] Pair find_closest_pair(std::uint32_t last) const noexcept {
        const Floats least = best_.least_everywhere();
        const Integers a = Integers::filled(next_lane(equal(best_, least).bits(), last));
        const Integers b = permuted(closest_, a);
        return {min(a, b), max(a, b), least};
    }

    /// Puts the box around both of the pair into the lane of one, and the last cluster into that of the other.
    void merge(const Pair& pair) noexcept {
        const Integers last = Integers::filled(--count_);
        const Mask is_low = equal(Integers::lane_numbers(), pair.low);
        const Integers from = select(equal(Integers::lane_numbers(), pair.high), last, Integers::lane_numbers());
        Floats merged[6];
        for (std::size_t i = 0; i < 6; ++i) {
            const Floats low = permuted(bounds_[i], pair.low);
            const Floats high = permuted(bounds_[i], pair.high);
            merged[i] = i < 3 ? min(low, high) : max(low, high);
            bounds_[i] = select(is_low, merged[i], permuted(bounds_[i], from));
        }
        best_ = select(valid(), permuted(best_, from), far());
        closest_ = permuted(closest_, from);

        const Mask others = except(valid(), is_low);
        const Floats distance = select(others, distances(merged), far());
        const Mask lost = (equal(closest_, pair.low) | equal(closest_, pair.high)) & others;
        closest_ = select(equal(closest_, last), pair.high, closest_);
        // The merged cluster is no closer than its parts were; where it is as close, there is nothing to look for.
        const Mask kept = lost & equal(distance, best_);
        closest_ = select(kept, pair.low, closest_);
        set_closest(pair.low_lane(), is_low, distance);
        for (std::uint32_t bits = except(lost, kept).bits(); bits != 0; bits &= bits - 1)
            find_best_match(static_cast<std::uint32_t>(std::countr_zero(bits)));
    }

private:
    void load_bounds(const Cluster* primitives) noexcept {
        Float4 halves[2][2][4];  // of lanes, of corners, of coordinates
        for (std::uint32_t half = 0; half < 2; ++half) {
            if (half == 1 && count_ <= 4) continue;
            for (std::uint32_t i = 0; i < 4; ++i) {
                const Node& node = primitives[std::min(4 * half + i, count_ - 1)].node;
                halves[half][0][i] = Float4::load(node.lower);
                halves[half][1][i] = Float4::load(node.upper);
            }
            for (auto& corner : halves[half])
                Float4::transpose(corner[0], corner[1], corner[2], corner[3]);
        }
        for (std::size_t i = 0; i < 6; ++i) {
            const Float4 first = halves[0][i / 3][i % 3];
            bounds_[i] = Floats::of_halves(first, count_ <= 4 ? first : halves[1][i / 3][i % 3]);
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
        const Mask closer = less(distance, best_) & lanes;
        best_ = select(closer, distance, best_);
        closest_ = select(closer, other, closest_);
    }

    void find_best_match(std::uint32_t cluster) noexcept {
        const Integers lane = Integers::filled(cluster);
        const Mask is_cluster = equal(Integers::lane_numbers(), lane);
        Floats box[6];
        for (std::size_t i = 0; i < 6; ++i)
            box[i] = permuted(bounds_[i], lane);
        set_closest(cluster, is_cluster, select(except(valid(), is_cluster), distances(box), far()));
    }

    void set_closest(std::uint32_t cluster, Mask is_cluster, Floats distance) noexcept {
        const Floats least = distance.least_everywhere();
        best_ = select(is_cluster, least, best_);
        closest_ = select(is_cluster, Integers::filled(next_lane(equal(distance, least).bits(), cluster)), closest_);
    }

    /// The first of `bits` behind `before`, or else the first of all. There is one.
    [[nodiscard]] static std::uint32_t next_lane(std::uint32_t bits, std::uint32_t before) noexcept {
        const std::uint32_t behind = bits & (~std::uint32_t{1} << before);
        return static_cast<std::uint32_t>(std::countr_zero(behind != 0 ? behind : bits));
    }

    [[nodiscard]] Mask valid() const noexcept { return Floats::first_lanes(count_); }
    [[nodiscard]] static Floats far() noexcept { return Floats::filled(kFar); }

    std::uint32_t count_;
    Floats bounds_[6];  ///< As those of Stack.
    Floats best_;       ///< Infinite in lanes without a cluster.
    Integers closest_;  ///< Lanes.
};
