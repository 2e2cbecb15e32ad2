#pragma once

#include <string_view>

#include "device/tree/device_optimizer_row.hpp"

namespace clbvh::device {

/// How much of everything reinsertion keeps in scratch.
struct ReinsertSizes {
    std::uint64_t nodes;
    std::uint64_t candidates;  ///< Most of a pass.
    std::uint64_t groups;      ///< Of launches over candidates.
    std::uint64_t box_groups;  ///< Of those among them in which groups hand over to each other.
    std::uint64_t blocks;      ///< Of launches over slots.

    ReinsertSizes(const OptimizeSettings& settings, std::uint32_t node_count);
};

/// Views of the scratch: kernels/tree/reinsert*.cl say what each is.
struct ReinsertViews {
    ReinsertViews(const ReinsertSizes& sizes, ArrayLayout layout);

    cl::Buffer parents, arrivals, ranks, locks, moving, histogram, counts, found, state, move_changes, box_changes,
        control, area;
    std::uint64_t bytes;  ///< of all of them
};

/// The steps of reinsertion on one tree, in their order; all of a pass but begin() is repeated. None waits.
class ReinsertPasses {
public:
    explicit ReinsertPasses(const OptimizeJob& job)
        : job_(job), sizes_(job.settings, job.tree.node_count), v_(sizes_, ArrayLayout(job.scratch)) {}

    void begin();                 ///< Finds parents, rates all nodes, adds up their areas.
    void choose();                ///< Candidates.
    void search();                ///< The best place of each.
    void lock();                  ///< Which moves can be made together.
    void move();                  ///< Makes them; boxes are not yet brought up to date.
    void refit(bool is_undoing);  ///< The boxes above what move() or undo() changed.
    void end();                   ///< Whether the pass stays, and what the next one does.
    void undo();                  ///< Takes all moves back, unless the pass stays.

    [[nodiscard]] const ReinsertViews& views() const noexcept { return v_; }
    [[nodiscard]] const ReinsertSizes& sizes() const noexcept { return sizes_; }

private:
    [[nodiscard]] const cl::Buffer& nodes() const { return job_.tree.nodes; }
    Kernel& kernel(std::string_view file, const char* name);
    template <class... Arguments>
    void launch(std::string_view file, const char* name, std::size_t groups, const Arguments&... arguments);
    template <class... Arguments>
    void launch_on_slots(const char* name, const Arguments&... arguments);

    const OptimizeJob& job_;
    ReinsertSizes sizes_;
    ReinsertViews v_;
};

}  // namespace clbvh::device
