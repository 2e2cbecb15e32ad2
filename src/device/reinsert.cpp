// Meister, Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization".

#include <algorithm>

#include "device/device_optimizer_row.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPasses = 64;
constexpr std::uint64_t kSlotsPerGroup = 4096;  // SLOTS_PER_GROUP of kernels/tree_nodes.clh
constexpr std::uint64_t kRanks = 2049;          // RANKS of kernels/reinsert_state.clh, as the next four
constexpr std::uint64_t kControlBytes = 64;
constexpr std::uint64_t kFoundBytes = 16;
constexpr std::uint64_t kChangeBytes = 16;
constexpr std::uint32_t kCandidatesDivisor = 10;  // MOST_PART of kernels/reinsert_refit.cl
// Work groups of a launch over candidates, as multiples of those that fill the device: searches differ in work.
constexpr std::uint32_t kLaneGroups = 16;
constexpr std::uint32_t kGroups = 4;

std::vector<ProgramSpec> programs(const OptimizeSettings& settings) {
    const std::size_t group = settings.stream_group_size;
    return {parents_program(group),
            {"reinsert_choose.cl", group, ""},
            {"reinsert.cl", group, ""},
            {"reinsert_refit.cl", group, ""}};
}

/// What the passes keep in scratch, in bytes; see the kernels.
struct Sizes {
    std::uint64_t nodes;
    std::uint64_t candidates;
    std::uint64_t groups;
    std::uint64_t blocks;

    Sizes(const OptimizeSettings& settings, std::uint32_t node_count)
        : nodes(node_count),
          candidates(node_count / kCandidatesDivisor + 1),
          groups(std::uint64_t{settings.groups_to_fill} * (settings.lane() ? kLaneGroups : kGroups)),
          blocks((nodes + kSlotsPerGroup - 1) / kSlotsPerGroup) {}
};

/// Views of the scratch, one behind the other; without a buffer only the bytes are added up.
class Views {
public:
    Views(const Sizes& sizes, const Block& scratch) : scratch_(scratch) {
        parents = take(4 * sizes.nodes / 2);
        arrivals = take(4 * sizes.nodes / 2);
        ranks = take(2 * sizes.nodes);
        locks = take(8 * sizes.nodes);
        moving = take(4 * sizes.nodes);
        histogram = take(4 * kRanks);
        counts = take(8 * sizes.blocks);
        found = take(kFoundBytes * sizes.candidates);
        state = take(4 * sizes.candidates);
        move_changes = take(kChangeBytes * sizes.groups);
        box_changes = take(kChangeBytes * sizes.groups);
        control = take(kControlBytes);
        area = take(8);
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept { return end_; }

    cl::Buffer parents, arrivals, ranks, locks, moving, histogram, counts, found, state, move_changes, box_changes,
        control, area;

private:
    cl::Buffer take(std::uint64_t bytes) {
        const std::uint64_t begin = end_;
        end_ += align_for_views(bytes);
        return scratch_.buffer() != nullptr ? view_of(scratch_, begin, bytes) : cl::Buffer();
    }

    const Block& scratch_;
    std::uint64_t end_ = 0;
};

std::uint64_t scratch_bytes(const OptimizeSettings& settings, std::uint32_t node_count) {
    return Views(Sizes(settings, node_count), Block{}).bytes();
}

/// The passes over one tree.
class ReinsertPasses {
public:
    explicit ReinsertPasses(const OptimizeJob& job)
        : job_(job), sizes_(job.settings, job.tree.node_count), v_(sizes_, job.scratch) {}

    void run() {
        begin();
        const std::uint32_t passes = job_.settings.passes != 0 ? job_.settings.passes : kPasses;
        for (std::uint32_t pass = 0; pass < passes; ++pass) {
            choose();
            launch("reinsert.cl", "find_places", sizes_.groups, nodes(), v_.parents, v_.control, v_.found, v_.state);
            lock();
            launch("reinsert.cl", "make_moves", sizes_.groups, nodes(), v_.parents, v_.control, v_.found, v_.state,
                   v_.moving, v_.move_changes);
            refit(false);
            launch("reinsert_refit.cl", "end_pass", 1, v_.move_changes, v_.box_changes,
                   static_cast<std::uint32_t>(sizes_.groups), v_.control, v_.area);
            launch("reinsert.cl", "undo_moves", sizes_.groups, nodes(), v_.parents, v_.control, v_.found, v_.state);
            refit(true);
        }
    }

private:
    [[nodiscard]] const cl::Buffer& nodes() const { return job_.tree.nodes; }
    Kernel& kernel(std::string_view file, const char* name) {
        return job_.launcher.session().kernel(ProgramSpec{file, job_.settings.stream_group_size, ""}, name);
    }
    template <class... Arguments>
    void launch(std::string_view file, const char* name, std::size_t groups, const Arguments&... arguments) {
        job_.launcher.launch(kernel(file, name), groups, arguments...);
    }
    template <class... Arguments>
    void launch_on_slots(const char* name, const Arguments&... arguments) {
        launch_on_tree(job_.launcher, kernel("reinsert_choose.cl", name), sizes_.blocks, job_.tree, arguments...);
    }

    void begin() {
        launch_parents(job_.launcher, job_.settings.stream_group_size, job_.tree, v_.parents);
        launch_on_slots("begin_reinsertion", v_.locks, v_.moving, v_.arrivals, v_.histogram, v_.control);
        const Pieces pieces = cut_into_pieces(job_.tree.node_count / 2, static_cast<std::uint32_t>(sizes_.groups),
                                              static_cast<std::uint32_t>(kSlotsPerGroup / 2));
        launch_on_tree(job_.launcher, kernel("reinsert_choose.cl", "rate_nodes"), pieces.count, job_.tree, v_.parents,
                       pieces.length, v_.control, v_.ranks, v_.histogram, v_.box_changes);
        launch("reinsert_choose.cl", "begin_passes", 1, v_.box_changes, pieces.count, v_.area);
    }

    void choose() {
        launch("reinsert_choose.cl", "choose_threshold", 1, v_.histogram, static_cast<std::uint32_t>(sizes_.candidates),
               v_.control);
        launch_on_slots("count_candidates", v_.ranks, v_.control, v_.counts);
        launch("reinsert_choose.cl", "scan_counts", 1, static_cast<std::uint32_t>(sizes_.blocks), v_.control,
               v_.counts);
        launch_on_slots("collect_candidates", v_.ranks, v_.control, v_.counts, v_.found);
    }

    void lock() {
        for (const char* const name : {"lock_gains", "lock_ties"})
            launch("reinsert.cl", name, sizes_.groups, v_.parents, v_.control, v_.found, v_.locks);
        launch("reinsert.cl", "find_winners", sizes_.groups, v_.parents, v_.control, v_.found, v_.locks, v_.state,
               v_.moving);
        launch("reinsert.cl", "check_targets", sizes_.groups, v_.parents, v_.control, v_.found, v_.moving, v_.locks,
               v_.state);
    }

    void refit(bool is_undoing) {
        const std::uint32_t undoing = is_undoing ? 1 : 0;
        launch("reinsert_refit.cl", "mark_changes", sizes_.groups, v_.parents, v_.control, undoing, v_.found, v_.state,
               v_.arrivals);
        launch("reinsert_refit.cl", "refit_changes", sizes_.groups, nodes(), v_.parents, v_.control, undoing, v_.found,
               v_.state, v_.arrivals, v_.ranks, v_.histogram, v_.box_changes);
    }

    const OptimizeJob& job_;
    Sizes sizes_;
    Views v_;
};

void launch(const OptimizeJob& job) {
    ReinsertPasses(job).run();
}

}  // namespace

const DeviceOptimizerRow kReinsert{programs, scratch_bytes, launch};

}  // namespace clbvh::device
