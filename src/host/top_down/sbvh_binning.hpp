#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "host/build/cost_unit.hpp"
#include "host/top_down/config_rules.hpp"
#include "host/top_down/sbvh_clip.hpp"

namespace clbvh::host {

/// Maps positions to equal slabs along each axis of a box.
class SpatialBinning {
public:
    SpatialBinning(const Box4& box, std::uint32_t bin_count) noexcept;

    /// Bins of a point inside the box along x, y and z, into `bins`, which takes four.
    void bins_of(Float4 point, std::int32_t* bins) const noexcept {
        max(min((point - base_) * scale_, last_), Float4::filled(0.0f)).truncate(bins);
    }
    /// As bins_of for any point: -1 before the first bin, bin_count() behind the last.
    void bins_around(Float4 point, std::int32_t* bins) const noexcept;

    /// Where `bin` begins.
    [[nodiscard]] float plane(std::size_t axis, std::uint32_t bin) const noexcept {
        return lower_[axis] + static_cast<float>(bin) * step_[axis];
    }
    /// False along an axis that has one bin only.
    [[nodiscard]] bool divides(std::size_t axis) const noexcept { return step_[axis] > 0.0f; }
    [[nodiscard]] std::uint32_t bin_count() const noexcept { return bin_count_; }
    /// Weight of a reference in the costs of splits, see cost_unit().
    [[nodiscard]] float unit() const noexcept { return unit_; }

private:
    Float4 base_;
    Float4 scale_;
    Float4 last_;
    std::uint32_t bin_count_;
    float unit_;
    std::array<float, 3> lower_;
    std::array<float, 3> step_;
};

/// A plane between bins: what lies in bins below `bin` along `axis` goes left, the rest right, straddlers are cut.
struct SpatialSplit {
    float cost = std::numeric_limits<float>::infinity();  ///< Half area times weight, left and right together.
    std::uint32_t axis = 3;                               ///< 3: there is no such plane.
    std::uint32_t bin = 0;
    std::uint32_t left_count = 0;
    std::uint32_t right_count = 0;
    Box4 left_box;
    Box4 right_box;

    [[nodiscard]] bool found() const noexcept { return axis < 3; }
};

/// A box that starts uninitialised, so that of large arrays only what is used is written.
struct BoxSlot {
    Float4 lower;
    Float4 upper;

    void clear() noexcept { *this = {Box4{}.lower, Box4{}.upper}; }
    void merge(const Box4& box) noexcept {
        lower = min(lower, box.lower);
        upper = max(upper, box.upper);
    }
    void merge(Float4 point) noexcept { merge(Box4{point, point}); }
    [[nodiscard]] Box4 box() const noexcept { return {lower, upper}; }
};

/// References bounded bin by bin along all axes, and counted where they enter and leave. Section 4.2 of the paper.
class SpatialBinSet {
public:
    explicit SpatialBinSet(std::uint32_t bin_count) noexcept;

    /// Without a mesh, the parts of a reference are those of its box.
    void add(const MeshView* mesh, std::span<const Reference> references, const SpatialBinning& binning) noexcept;
    void add(const SpatialBinSet& other) noexcept;

    /// The cheapest plane that makes `most_references` at most; the first one along the first axis among equals.
    [[nodiscard]] SpatialSplit find_split(const SpatialBinning& binning, std::uint32_t most_references) const noexcept;

private:
    /// The bins of one reference along all axes.
    struct Span {
        std::int32_t first[4];
        std::int32_t last[4];
    };

    void add_parts(const CutTriangle& triangle, const Box4& box, const Span& span,
                   const SpatialBinning& binning) noexcept;
    void add_box_parts(const Box4& box, const Span& span, const SpatialBinning& binning) noexcept;
    void sweep_axis(std::uint32_t axis, std::uint32_t most_references, float unit, SpatialSplit& best) const noexcept;

    std::uint32_t bin_count_;
    std::array<std::array<BoxSlot, kMaxBinCount>, 3> boxes_;
    std::array<std::array<std::uint32_t, kMaxBinCount>, 3> entries_;
    std::array<std::array<std::uint32_t, kMaxBinCount>, 3> exits_;
};

}  // namespace clbvh::host
