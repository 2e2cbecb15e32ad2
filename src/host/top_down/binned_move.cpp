#include "host/top_down/binned_move.hpp"

#include <limits>

#include "core/simd/box8.hpp"
#include "core/simd/prefetch.hpp"

namespace clbvh::host {
namespace {

/// References ahead of the one at work that are asked for.
constexpr std::size_t kPrefetch = 64;

/// The bounds of one side, while references are added to it.
template <typename Box>
struct SideBounds {
    Box box, centroids;

    CLBVH_ALWAYS_INLINE explicit SideBounds(const Bounds& side) noexcept
        : box(load(side.box)), centroids(load(side.centroids)) {}

    static CLBVH_ALWAYS_INLINE Box load(const Box4& source) noexcept {
        alignas(32) float lanes[8];
        source.lower.store(lanes);
        source.upper.negated().store(lanes + 4);
        return Box::load(lanes);
    }
    static CLBVH_ALWAYS_INLINE Box4 stored(const Box& source) noexcept {
        alignas(32) float lanes[8];
        source.store(lanes);
        // Subtracted from 0, not negated: what was +0 must not become -0.
        return {Float4::load(lanes), Float4::filled(0.0f) - Float4::load(lanes + 4)};
    }
    [[nodiscard]] CLBVH_ALWAYS_INLINE Bounds side() const noexcept { return {stored(box), stored(centroids)}; }

    /// An infinite penalty leaves the reference out.
    CLBVH_ALWAYS_INLINE void add(const Box& reference_box, const Box& centroid, float penalty) noexcept {
        box.merge(reference_box.penalized(penalty));
        centroids.merge(centroid.penalized(penalty));
    }
};

template <typename Box>
CLBVH_ALWAYS_INLINE std::uint32_t move(std::span<const Reference> range, const Binning& binning,
                                       const BinnedSplit& split, Reference* left, Reference* right,
                                       Sides& sides) noexcept {
    constexpr float penalties[2] = {0.0f, std::numeric_limits<float>::infinity()};
    const Reference* const first_left = left;
    SideBounds<Box> lefts(sides[0]), rights(sides[1]);
    for (std::size_t i = 0; i < range.size(); ++i) {
        prefetch(range.data() + i + kPrefetch);
        const Reference& reference = range[i];
        std::int32_t bins[4];
        binning.bins_of(reference, bins);
        const bool goes_right = static_cast<std::uint32_t>(bins[split.axis]) >= split.bin;
        const Box box = Box::of(reference);
        const Box centroid = box.doubled_centroid();
        lefts.add(box, centroid, penalties[goes_right]);
        rights.add(box, centroid, penalties[!goes_right]);
        right -= goes_right;
        *(goes_right ? right : left) = reference;
        left += !goes_right;
    }
    sides = {lefts.side(), rights.side()};
    return static_cast<std::uint32_t>(left - first_left);
}

#if defined(CLBVH_HAS_AVX2_FUNCTIONS)
CLBVH_AVX2_FUNCTION std::uint32_t move_avx2(std::span<const Reference> range, const Binning& binning,
                                            const BinnedSplit& split, Reference* left, Reference* right,
                                            Sides& sides) noexcept {
    return move<Box8Avx>(range, binning, split, left, right, sides);
}
#else
constexpr auto move_avx2 = move<Box8Pair>;
#endif

}  // namespace

std::uint32_t move_references(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split,
                              Reference* left, Reference* right, Sides& sides) noexcept {
    return (use_avx2 ? move_avx2 : move<Box8Pair>)(range, binning, split, left, right, sides);
}

}  // namespace clbvh::host
