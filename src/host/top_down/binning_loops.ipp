// The loops of binned builders over references and bins, in terms of the vectors of core/simd. Files that are compiled
// for different instruction sets include this one within an anonymous namespace, so that none calls another's copy.

using simd::Box8;

template <typename Set>
CLBVH_ALWAYS_INLINE void merge_into(float* target, const Box8<Set>& box) noexcept {
    Box8<Set> merged = Box8<Set>::load(target);
    merged.merge(box);
    merged.store(target);
}

/// Written as it is read next: a load of eight lanes has to wait where two stores of four wrote them.
template <typename Set>
CLBVH_ALWAYS_INLINE void clear(BinRow& row) noexcept {
    const Box8<Set> empty = Box8<Set>::load(kEmptyRow.boxes[0]);
    for (std::size_t axis = 0; axis < 3; ++axis)
        empty.store(row.boxes[axis]);
    for (auto& count : row.counts)
        count = 0;
}

template <typename Set>
CLBVH_ALWAYS_INLINE void add_to_row(BinRow* rows, std::int32_t bin, std::size_t axis, const Box8<Set>& box) noexcept {
    BinRow& row = rows[bin];
    merge_into(row.boxes[axis], box);
    ++row.counts[axis];
}

template <typename Set>
void add_references(BinRow* rows, std::span<const Reference> references, const Binning& binning) noexcept {
    for (std::size_t i = 0; i < references.size(); ++i) {
        std::int32_t bins[4];
        binning.bins_of(references[i], bins);
        const Box8<Set> box = Box8<Set>::of(references[i]);
        add_to_row(rows, bins[0], 0, box);
        add_to_row(rows, bins[1], 1, box);
        add_to_row(rows, bins[2], 2, box);
    }
}

/// The boxes to one side of a border, along the three axes at once.
template <typename Set>
struct Sweep {
    using Float4 = typename Set::Float4;
    using Int4 = typename Set::Int4;

    Box8<Set> x, y, z;
    Int4 count{};

    CLBVH_ALWAYS_INLINE explicit Sweep(const BinRow& row) noexcept
        : x(Box8<Set>::load(row.boxes[0])),
          y(Box8<Set>::load(row.boxes[1])),
          z(Box8<Set>::load(row.boxes[2])),
          count(Int4::load(row.counts)) {}

    CLBVH_ALWAYS_INLINE void add(const BinRow& row) noexcept {
        x.merge(Box8<Set>::load(row.boxes[0]));
        y.merge(Box8<Set>::load(row.boxes[1]));
        z.merge(Box8<Set>::load(row.boxes[2]));
        count = count + Int4::load(row.counts);
    }
    /// Not a number where nothing is on this side: infinite extents, of nothing.
    [[nodiscard]] CLBVH_ALWAYS_INLINE Float4 cost(Float4 unit) const noexcept {
        return half_areas_of_extents(x.negated_extents(), y.negated_extents(), z.negated_extents()) *
               (count.to_float() * unit);
    }
};

template <typename Set>
CLBVH_ALWAYS_INLINE BinnedSplit find_border(const BinRow* rows, std::uint32_t row_count, float unit) noexcept {
    using Float4 = typename Set::Float4;
    const Float4 units = Float4::filled(unit);
    std::array<Float4, kMaxBinCount> right_costs;
    Sweep<Set> right(rows[row_count - 1]);
    for (std::uint32_t bin = row_count - 1; bin > 0; --bin) {
        right_costs[bin] = right.cost(units);
        right.add(rows[bin - 1]);
    }
    Float4 best_cost = Float4::filled(std::numeric_limits<float>::infinity());
    Float4 best_bin = Float4::filled(0.0f);
    Sweep<Set> left(rows[0]);
    for (std::uint32_t bin = 1; bin < row_count; ++bin) {
        const Float4 cost = left.cost(units) + right_costs[bin];
        const auto is_less = less(cost, best_cost);
        best_bin = select(is_less, Float4::filled(static_cast<float>(bin)), best_bin);
        best_cost = select(is_less, cost, best_cost);
        left.add(rows[bin]);
    }
    float costs[4], bins[4];
    best_cost.store(costs);
    best_bin.store(bins);
    BinnedSplit best;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        if (costs[axis] < best.cost) best = {costs[axis], axis, static_cast<std::uint32_t>(bins[axis])};
    }
    return best;
}

/// Bins that hold something, in one bit each.
using BinMask = std::uint64_t;
static_assert(kMaxBinCount <= 64);

[[nodiscard]] CLBVH_ALWAYS_INLINE std::int32_t rank(BinMask occupied, std::int32_t bin) noexcept {
    return std::popcount(occupied & ((BinMask{1} << bin) - 1));
}

/// Only bins that hold something get a row.
template <typename Set>
BinnedSplit find_border_of_few(std::span<const Reference> references, const Binning& binning, float unit) noexcept {
    std::array<std::array<std::int32_t, 4>, kFewReferences> bins;
    std::array<BinMask, 3> occupied{};
    for (std::size_t i = 0; i < references.size(); ++i) {
        binning.bins_of(references[i], bins[i].data());
        for (std::size_t axis = 0; axis < 3; ++axis)
            occupied[axis] |= BinMask{1} << bins[i][axis];
    }
    const int row_count =
        std::max({std::popcount(occupied[0]), std::popcount(occupied[1]), std::popcount(occupied[2])});
    std::array<BinRow, kFewReferences> rows;
    for (int row = 0; row < row_count; ++row)
        clear<Set>(rows[static_cast<std::size_t>(row)]);
    for (std::size_t i = 0; i < references.size(); ++i) {
        const Box8<Set> box = Box8<Set>::of(references[i]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            add_to_row(rows.data(), rank(occupied[axis], bins[i][axis]), axis, box);
    }
    BinnedSplit split = find_border<Set>(rows.data(), static_cast<std::uint32_t>(row_count), unit);
    if (!split.found()) return split;
    // From the number of occupied bins on the left to the bin behind the last of them.
    BinMask left = occupied[split.axis];
    for (std::uint32_t i = 1; i < split.bin; ++i)
        left &= left - 1;
    split.bin = static_cast<std::uint32_t>(std::countr_zero(left)) + 1;
    return split;
}

/// The bounds of one side, while references are added to it.
template <typename Set>
struct SideBounds {
    Box8<Set> box, centroids;

    CLBVH_ALWAYS_INLINE explicit SideBounds(const Bounds& side) noexcept
        : box(load(side.box)), centroids(load(side.centroids)) {}

    static CLBVH_ALWAYS_INLINE Box8<Set> load(const Box4& source) noexcept {
        alignas(32) float lanes[8];
        source.lower.store(lanes);
        source.upper.negated().store(lanes + 4);
        return Box8<Set>::load(lanes);
    }
    static CLBVH_ALWAYS_INLINE Box4 stored(const Box8<Set>& source) noexcept {
        alignas(32) float lanes[8];
        source.store(lanes);
        // Subtracted from 0, not negated: what was +0 must not become -0.
        return {Float4::load(lanes), Float4::filled(0.0f) - Float4::load(lanes + 4)};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Bounds side() const noexcept { return {stored(box), stored(centroids)}; }

    /// An infinite penalty leaves the reference out.
    CLBVH_ALWAYS_INLINE void add(const Box8<Set>& reference_box, const Box8<Set>& centroid, float penalty) noexcept {
        box.merge(reference_box.penalized(penalty));
        centroids.merge(centroid.penalized(penalty));
    }
};

template <typename Set>
std::uint32_t move(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split, Reference* left,
                   Reference* right, Sides& sides) noexcept {
    constexpr float penalties[2] = {0.0f, std::numeric_limits<float>::infinity()};
    const Reference* const first_left = left;
    SideBounds<Set> lefts(sides[0]), rights(sides[1]);
    for (std::size_t i = 0; i < range.size(); ++i) {
        const Reference& reference = range[i];
        std::int32_t bins[4];
        binning.bins_of(reference, bins);
        const bool goes_right = static_cast<std::uint32_t>(bins[split.axis]) >= split.bin;
        const Box8<Set> box = Box8<Set>::of(reference);
        const Box8<Set> centroid = box.doubled_centroid();
        lefts.add(box, centroid, penalties[goes_right]);
        rights.add(box, centroid, penalties[!goes_right]);
        right -= goes_right;
        *(goes_right ? right : left) = reference;
        left += !goes_right;
    }
    sides = {lefts.side(), rights.side()};
    return static_cast<std::uint32_t>(left - first_left);
}

template <typename Set>
constexpr BinningLoops kLoops{add_references<Set>, find_border<Set>, find_border_of_few<Set>, move<Set>};
