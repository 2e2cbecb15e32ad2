// Meister, Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization".
#include "device/tree/reinsert.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint32_t kPasses = 32;
constexpr std::uint64_t kRanks = kernels::RANKS;
constexpr std::uint64_t kControlBytes = sizeof(cl_uint) * kernels::CONTROL_WORDS;
constexpr std::uint64_t kFoundBytes = kernels::FOUND_BYTES;
constexpr std::uint64_t kChangeBytes = kernels::CHANGE_BYTES;
// Work groups of a launch over candidates, as multiples of those that fill the device: searches differ in work.
constexpr std::uint32_t kLaneGroups = 16;
constexpr std::uint32_t kGroups = 4;
constexpr std::uint64_t kLeastShare = 16;  // candidates that make a group worth its launch

constexpr std::string_view kChoose = "reinsert_choose.cl";
constexpr std::string_view kMoves = "reinsert.cl";
constexpr std::string_view kRefit = "reinsert_refit.cl";

std::vector<ProgramSpec> programs(const OptimizeSettings& settings) {
    const std::size_t group = settings.stream_group_size;
    return {parents_program(group), {kChoose, group, ""}, {kMoves, group, ""}, {kRefit, group, ""}};
}

std::uint64_t lane_local_bytes(const OptimizeSettings&) {
    return kRanks * 4;  // reinsert_choose.cl
}

std::uint64_t scratch_bytes(const OptimizeSettings& settings, std::uint32_t node_count) {
    return ReinsertViews(ReinsertSizes(settings, node_count), ArrayLayout()).bytes;
}

void launch(const OptimizeJob& job) {
    ReinsertPasses passes(job);
    passes.begin();
    const std::uint32_t count = job.settings.passes != 0 ? job.settings.passes : kPasses;
    for (std::uint32_t pass = 0; pass < count; ++pass) {
        passes.choose();
        passes.search();
        passes.lock();
        passes.move();
        passes.refit(false);
        passes.end();
        passes.undo();
        passes.refit(true);
    }
}

}  // namespace

ReinsertSizes::ReinsertSizes(const OptimizeSettings& settings, std::uint32_t node_count)
    : nodes(node_count),
      candidates(node_count / kernels::MOST_PART_DIVISOR + 1),
      groups(std::min(std::uint64_t{settings.groups_to_fill} * (settings.lane() ? kLaneGroups : kGroups),
                      candidates / kLeastShare + 1)),
      box_groups(meeting_groups(settings.hand_over, groups)),
      blocks(slot_groups(node_count)) {}

ReinsertViews::ReinsertViews(const ReinsertSizes& sizes, ArrayLayout layout)
    : parents(layout.take_view(4 * sizes.nodes / 2)),
      arrivals(layout.take_view(4 * sizes.nodes / 2)),
      ranks(layout.take_view(2 * sizes.nodes)),
      locks(layout.take_view(8 * sizes.nodes)),
      moving(layout.take_view(4 * sizes.nodes)),
      histogram(layout.take_view(4 * kRanks)),
      counts(layout.take_view(8 * sizes.blocks)),
      found(layout.take_view(kFoundBytes * sizes.candidates)),
      state(layout.take_view(4 * sizes.candidates)),
      move_changes(layout.take_view(kChangeBytes * sizes.groups)),
      box_changes(layout.take_view(kChangeBytes * sizes.groups)),
      control(layout.take_view(kControlBytes)),
      area(layout.take_view(8)),
      bytes(layout.bytes()) {}

Kernel& ReinsertPasses::kernel(std::string_view file, const char* name) {
    return job_.launcher.session().kernel(ProgramSpec{file, job_.settings.stream_group_size, ""}, name);
}

template <class... Arguments>
void ReinsertPasses::launch(std::string_view file, const char* name, std::size_t groups,
                            const Arguments&... arguments) {
    job_.launcher.launch(kernel(file, name), groups, arguments...);
}

template <class... Arguments>
void ReinsertPasses::launch_on_slots(const char* name, const Arguments&... arguments) {
    launch_on_tree(job_.launcher, kernel(kChoose, name), sizes_.blocks, job_.tree, arguments...);
}

void ReinsertPasses::begin() {
    launch_parents(job_.launcher, job_.settings.stream_group_size, job_.tree, v_.parents);
    launch_on_slots("begin_reinsertion", v_.locks, v_.moving, v_.arrivals, v_.histogram, v_.control);
    const Pieces pieces =
        cut_into_pieces(job_.tree.node_count / 2, static_cast<std::uint32_t>(sizes_.groups), kSlotsPerGroup / 2);
    launch_on_tree(job_.launcher, kernel(kChoose, "rate_nodes"), pieces.count, job_.tree, v_.parents, pieces.length,
                   v_.control, v_.ranks, v_.histogram, v_.box_changes);
    launch(kChoose, "begin_passes", 1, v_.box_changes, pieces.count, v_.area);
}

void ReinsertPasses::choose() {
    launch(kChoose, "choose_threshold", 1, v_.histogram, static_cast<std::uint32_t>(sizes_.candidates), v_.control);
    launch_on_slots("count_candidates", v_.ranks, v_.control, v_.counts);
    launch(kChoose, "scan_candidates", 1, static_cast<std::uint32_t>(sizes_.blocks), v_.control, v_.counts);
    launch_on_slots("collect_candidates", v_.ranks, v_.control, v_.counts, v_.found);
}

void ReinsertPasses::search() {
    launch(kMoves, "find_places", sizes_.groups, nodes(), v_.parents, v_.control, v_.found, v_.state);
}

void ReinsertPasses::lock() {
    for (const char* const name : {"lock_gains", "lock_ties"})
        launch(kMoves, name, sizes_.groups, v_.parents, v_.control, v_.found, v_.locks);
    launch(kMoves, "find_winners", sizes_.groups, v_.parents, v_.control, v_.found, v_.locks, v_.state, v_.moving);
    launch(kMoves, "check_targets", sizes_.groups, v_.parents, v_.control, v_.found, v_.moving, v_.locks, v_.state);
}

void ReinsertPasses::move() {
    launch(kMoves, "make_moves", sizes_.groups, nodes(), v_.parents, v_.control, v_.found, v_.state, v_.moving,
           v_.move_changes);
}

void ReinsertPasses::refit(bool is_undoing) {
    const std::uint32_t undoing = is_undoing ? 1 : 0;
    launch(kRefit, "mark_changes", sizes_.groups, v_.parents, v_.control, undoing, v_.found, v_.state, v_.arrivals);
    launch(kRefit, "refit_changes", sizes_.box_groups, nodes(), v_.parents, v_.control, undoing, v_.found, v_.state,
           v_.arrivals, v_.ranks, v_.histogram, v_.box_changes);
}

void ReinsertPasses::end() {
    launch(kRefit, "end_pass", 1, v_.move_changes, static_cast<std::uint32_t>(sizes_.groups), v_.box_changes,
           static_cast<std::uint32_t>(sizes_.box_groups), v_.control, v_.area);
}

void ReinsertPasses::undo() {
    launch(kMoves, "undo_moves", sizes_.groups, nodes(), v_.parents, v_.control, v_.found, v_.state);
}

const DeviceOptimizerRow kReinsert{programs, lane_local_bytes, scratch_bytes, launch};

}  // namespace clbvh::device
