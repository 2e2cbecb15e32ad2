#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clbvh/core/mesh.hpp"
#include "host/build/host_stages.hpp"
#include "host/split/presplit.hpp"
#include "host/top_down/median_grid.hpp"

namespace clbvh::host {

/// How often each triangle of a mesh is split. Karras, Aila 2013, section 5: those first whose boxes have most surface
/// to lose, and that important planes cut.
class SplitPlan {
public:
    /// Host memory that a plan takes.
    static constexpr std::size_t kBytesPerTriangle = sizeof(float);

    /// At most `quota` times the active triangles are planned in all. The mesh has passed check_mesh; a stage has
    /// begun. The same on any number of threads.
    SplitPlan(const MeshView& mesh, float quota, HostStages& stages);

    [[nodiscard]] const MedianGrid& grid() const noexcept { return grid_; }

    /// (2^-level (A_box - A_ideal))^(1/3): the level of the most important plane through the box, the box's surface,
    /// and the least surface that boxes around any number of parts can have. 0 where no plane passes through it, and
    /// for an inactive triangle.
    [[nodiscard]] float priority(std::size_t triangle) const noexcept { return priorities_[triangle]; }

    /// The priority times one factor for the whole mesh, rounded down.
    [[nodiscard]] std::uint32_t splits(std::size_t triangle) const noexcept {
        return static_cast<std::uint32_t>(factor_ * double{priorities_[triangle]});
    }

private:
    [[nodiscard]] double sum_priorities() const;
    [[nodiscard]] std::uint64_t count_splits(double factor) const;
    void choose_factor(std::uint64_t most_splits);

    std::vector<float> priorities_;
    MedianGrid grid_;
    double factor_ = 0.0;
};

/// Splits a mesh that check_mesh has passed, at the most important planes first, as presplit() does by edges: the same
/// promises hold for the boxes. A triangle that no plane passes through any more has fewer parts than were planned.
void split_to_quota(const MeshView& mesh, float quota, HostStages& stages, PartBoxes& parts);

}  // namespace clbvh::host
