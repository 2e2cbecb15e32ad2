#include "device/tree/refit.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/bvh.hpp"
#include "device/build/bounds.hpp"
#include "device/tree/tree_cost.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kWord = sizeof(cl_uint);
constexpr std::uint64_t kBoundsBytes = 12 * sizeof(float);  // BOUNDS_FLOATS of kernels/build/scene_bounds.clh
constexpr std::uint32_t kRangesPerUnit = 32;
constexpr std::uint32_t kMostRanges = 1024;

ProgramSpec program(const RefitSettings& settings, std::string_view file) {
    const bool lane = settings.shape == Shape::lane;
    return {file, settings.work_group_size, lane ? " -D REFIT_RANGES=" + std::to_string(settings.ranges) : ""};
}

/// Cuts a block into views, one behind the other.
class Cutter {
public:
    explicit Cutter(const Block& block) : block_(block) {}
    cl::Buffer take(std::uint64_t bytes) {
        cl::Buffer view = view_of(block_, end_, bytes);
        end_ += align_for_views(bytes);
        return view;
    }

private:
    const Block& block_;
    std::uint64_t end_ = 0;
};

/// kernels/tree/refit_order.cl says what each is.
struct OrderViews {
    cl::Buffer parents, arrivals;
    cl::Buffer order, ranges;  // lane shape
};

std::uint64_t pairs_of(std::uint32_t node_count) {
    return (std::uint64_t{node_count} + 1) / 2;
}

std::uint64_t range_bytes(const RefitSettings& settings) {
    return kWord * (settings.ranges + 1);
}

OrderViews cut_order(const RefitSettings& settings, std::uint32_t node_count, const Block& block) {
    Cutter cutter(block);
    OrderViews views;
    views.parents = cutter.take(kWord * pairs_of(node_count));
    views.arrivals = cutter.take(kWord * pairs_of(node_count));
    if (settings.shape == Shape::lane) {
        views.order = cutter.take(2 * kWord * pairs_of(node_count));
        views.ranges = cutter.take(range_bytes(settings));
    }
    return views;
}

/// Partial sums of a tree's costs, before and after in the lane shape.
std::uint64_t sum_bytes(const RefitSettings& settings, std::uint32_t node_count) {
    return 2 * sizeof(float) * std::max<std::uint64_t>(settings.ranges + 1, slot_groups(node_count));
}

struct ScratchViews {
    BuildBuffers bounds;  // what the boxes of the primitives take
    CostSums before, after;
};

ScratchViews cut_scratch(const RefitSettings& settings, std::uint32_t node_count, std::uint32_t primitive_count,
                         const Block& block) {
    Cutter cutter(block);
    ScratchViews views;
    views.bounds.boxes = cutter.take(sizeof(Aabb) * primitive_count);
    views.bounds.partial_bounds = cutter.take(kBoundsBytes * BuildBuffers::kMostPieces);
    views.bounds.partial_counts = cutter.take(kWord * BuildBuffers::kMostPieces);
    views.bounds.bounds = cutter.take(kBoundsBytes);
    views.bounds.leaf_count = cutter.take(kWord);
    views.before.partial = cutter.take(sum_bytes(settings, node_count));
    views.after.partial = cutter.take(sum_bytes(settings, node_count));
    views.before.root_area = cutter.take(sizeof(float));
    views.after.root_area = cutter.take(sizeof(float));
    return views;
}

Block behind(const Block& block, std::uint64_t bytes) {
    return {block.buffer, block.offset + bytes};
}

void refit_in_lanes(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                    const cl::Buffer& primitive_ids, const OrderViews& order, const ScratchViews& scratch) {
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(settings, "refit.cl"), name);
    };
    const auto inner = static_cast<float>(settings.costs.inner);
    const auto primitive = static_cast<float>(settings.costs.primitive);
    const auto sum_flat_costs = [&](const CostSums& sums) {
        launch_flat_cost_sums(launcher, settings.work_group_size, tree, settings.costs, sums.partial,
                              settings.ranges + 1);
    };
    sum_flat_costs(scratch.before);
    launcher.launch(kernel("refit_ranges"), settings.ranges, tree.nodes, order.order, order.ranges, primitive_ids,
                    scratch.bounds.boxes, inner, primitive, scratch.before.partial, scratch.after.partial);
    launch_on_tree(launcher, kernel("refit_top"), 1, tree, order.order, order.ranges, primitive_ids,
                   scratch.bounds.boxes, inner, primitive, scratch.before.partial, scratch.after.partial,
                   scratch.before.root_area, scratch.after.root_area);
    sum_flat_costs(scratch.after);
}

void refit_in_groups(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                     const cl::Buffer& primitive_ids, const OrderViews& order, const ScratchViews& scratch) {
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(settings, "refit.cl"), name);
    };
    const std::size_t groups = slot_groups(tree.node_count);
    launch_cost_sums(launcher, settings.work_group_size, tree, settings.costs, scratch.before);
    launch_on_tree(launcher, kernel("fit_leaves"), groups, tree, primitive_ids, scratch.bounds.boxes);
    launch_on_tree(launcher, kernel("fit_inner"), groups, tree, order.parents, order.arrivals);
    launch_cost_sums(launcher, settings.work_group_size, tree, settings.costs, scratch.after);
}

}  // namespace

RefitSettings resolve_refit_settings(Session& session, Shape shape, const SahCosts& costs) {
    BuildOptions options;
    options.shape = shape;
    RefitSettings settings;
    settings.build = resolve_settings(options, session, {.chunks = false});
    settings.shape = settings.build.shape;
    settings.work_group_size = settings.build.stream_group_size;
    settings.ranges = std::min(kRangesPerUnit * session.info().compute_units, kMostRanges);
    settings.costs = costs;
    return settings;
}

std::vector<ProgramSpec> refit_programs(const RefitSettings& settings) {
    return {bounds_program(settings.build), parents_program(settings.work_group_size),
            tree_cost_program(settings.work_group_size), program(settings, "refit_order.cl"),
            program(settings, "refit.cl")};
}

std::uint64_t refit_order_bytes(const RefitSettings& settings, std::uint32_t node_count) {
    const std::uint64_t words = align_for_views(kWord * pairs_of(node_count));
    if (settings.shape != Shape::lane) return 2 * words;
    return 2 * words + align_for_views(2 * kWord * pairs_of(node_count)) + align_for_views(range_bytes(settings));
}

std::uint64_t refit_scratch_bytes(const RefitSettings& settings, std::uint32_t node_count,
                                  std::uint32_t primitive_count) {
    return align_for_views(sizeof(Aabb) * primitive_count) + align_for_views(kBoundsBytes * BuildBuffers::kMostPieces) +
           align_for_views(kWord * BuildBuffers::kMostPieces) + align_for_views(kBoundsBytes) + align_for_views(kWord) +
           2 * align_for_views(sum_bytes(settings, node_count)) + 2 * align_for_views(sizeof(float));
}

std::uint64_t quality_scratch_bytes(std::uint32_t node_count) {
    return align_for_views(2 * sizeof(float) * slot_groups(node_count)) + align_for_views(sizeof(float));
}

void launch_refit_order(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& order) {
    if (tree.node_count == 0) return;
    launcher.begin_stage("refit order", 0.0);
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(settings, "refit_order.cl"), name);
    };
    const OrderViews views = cut_order(settings, tree.node_count, order);
    const std::size_t groups = slot_groups(tree.node_count);
    launcher.launch(kernel("clear_arrivals"), groups, static_cast<std::uint32_t>(pairs_of(tree.node_count)),
                    views.arrivals);
    launch_parents(launcher, settings.work_group_size, tree, views.parents);
    if (settings.shape != Shape::lane) return;
    launch_on_tree(launcher, kernel("measure_subtrees"), groups, tree, views.parents, views.arrivals);
    launch_on_tree(launcher, kernel("plan_order"), 1, tree, views.arrivals, views.order, views.ranges);
    launcher.launch(kernel("write_order"), settings.ranges, tree.nodes, views.arrivals, views.order, views.ranges);
}

void launch_refit(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                  const cl::Buffer& primitive_ids, const DeviceMesh& mesh, const Block& order, const Block& scratch,
                  const Block& sah) {
    launcher.begin_stage("refit", 0.0);
    const OrderViews order_views = cut_order(settings, tree.node_count, order);
    const ScratchViews views = cut_scratch(settings, tree.node_count, mesh.primitive_count, scratch);
    launch_bounds(launcher, settings.build, views.bounds, mesh);
    const bool lane = settings.shape == Shape::lane;
    (lane ? refit_in_lanes : refit_in_groups)(launcher, settings, tree, primitive_ids, order_views, views);
    const auto sums = static_cast<std::uint32_t>(lane ? settings.ranges + 1 : slot_groups(tree.node_count));
    launch_cost(launcher, settings.work_group_size, views.before, sums, sah);
    launch_cost(launcher, settings.work_group_size, views.after, sums, behind(sah, sizeof(float)));
}

void launch_quality(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& scratch,
                    const Block& sah) {
    launcher.begin_stage("quality", 0.0);
    Cutter cutter(scratch);
    CostSums sums;
    sums.partial = cutter.take(2 * sizeof(float) * slot_groups(tree.node_count));
    sums.root_area = cutter.take(sizeof(float));
    launch_cost_sums(launcher, settings.work_group_size, tree, settings.costs, sums);
    launch_cost(launcher, settings.work_group_size, sums, static_cast<std::uint32_t>(slot_groups(tree.node_count)),
                sah);
}

}  // namespace clbvh::device
