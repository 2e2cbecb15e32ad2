#include "device/tree/refit.hpp"

#include <algorithm>
#include <string>

#include "clbvh/core/bvh.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kWord = sizeof(cl_uint);
constexpr std::uint32_t kRangesPerUnit = 32;
constexpr std::uint32_t kMostRanges = 1024;

ProgramSpec program(const RefitSettings& settings, std::string_view file) {
    return {file, settings.stream_group_size,
            settings.lane() ? " -D REFIT_RANGES=" + std::to_string(settings.ranges) : ""};
}

/// kernels/tree/refit_order.cl says what each is.
struct OrderViews {
    cl::Buffer parents, arrivals;
    cl::Buffer order, ranges;  // lane shape
};

std::uint64_t pairs_of(std::uint32_t node_count) {
    return (std::uint64_t{node_count} + 1) / 2;
}

OrderViews cut_order(ArrayLayout& layout, const RefitSettings& settings, std::uint32_t node_count) {
    OrderViews views;
    views.parents = layout.take_view(kWord * pairs_of(node_count));
    views.arrivals = layout.take_view(kWord * pairs_of(node_count));
    if (settings.lane()) {
        views.order = layout.take_view(2 * kWord * pairs_of(node_count));
        views.ranges = layout.take_view(kWord * (settings.ranges + 1));
    }
    return views;
}

OrderViews cut_order(const Block& order, const RefitSettings& settings, std::uint32_t node_count) {
    ArrayLayout layout(order);
    return cut_order(layout, settings, node_count);
}

CostSums cut_sums(ArrayLayout& layout, std::uint64_t count) {
    CostSums sums;
    sums.partial = layout.take_view(2 * sizeof(float) * count);
    sums.root_area = layout.take_view(sizeof(float));
    return sums;
}

void refit_in_lanes(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                    const cl::Buffer& primitive_ids, const cl::Buffer& boxes, const OrderViews& order,
                    const RefitScratch& scratch) {
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(settings, "refit.cl"), name);
    };
    const auto inner = static_cast<float>(settings.costs.inner);
    const auto primitive = static_cast<float>(settings.costs.primitive);
    const auto sum_flat_costs = [&](const CostSums& sums) {
        launch_flat_cost_sums(launcher, settings.stream_group_size, tree, settings.costs, sums.partial,
                              settings.ranges + 1);
    };
    sum_flat_costs(scratch.before);
    launcher.launch(kernel("refit_ranges"), settings.ranges, tree.nodes, order.order, order.ranges, primitive_ids,
                    boxes, inner, primitive, scratch.before.partial, scratch.after.partial);
    launch_on_tree(launcher, kernel("refit_top"), 1, tree, order.order, order.ranges, primitive_ids, boxes, inner,
                   primitive, scratch.before.partial, scratch.after.partial, scratch.before.root_area,
                   scratch.after.root_area);
    sum_flat_costs(scratch.after);
}

void refit_in_groups(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                     const cl::Buffer& primitive_ids, const cl::Buffer& boxes, const OrderViews& order,
                     const RefitScratch& scratch) {
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(settings, "refit.cl"), name);
    };
    const std::size_t groups = slot_groups(tree.node_count);
    launch_cost_sums(launcher, settings.stream_group_size, tree, settings.costs, scratch.before);
    launch_on_tree(launcher, kernel("fit_leaves"), groups, tree, primitive_ids, boxes);
    launch_on_tree(launcher, kernel("fit_inner"), meeting_groups(settings.hand_over, groups), tree, order.parents,
                   order.arrivals);
    launch_cost_sums(launcher, settings.stream_group_size, tree, settings.costs, scratch.after);
}

}  // namespace

RefitSettings resolve_refit_settings(Session& session, Shape shape, const SahCosts& costs) {
    RefitSettings settings;
    static_cast<DeviceFit&>(settings) = fit_to_device(session, shape);
    settings.ranges = std::min(kRangesPerUnit * session.info().compute_units, kMostRanges);
    settings.costs = costs;
    if (!settings.lane()) settings.hand_over = session.hand_over();
    return settings;
}

std::vector<ProgramSpec> refit_programs(const RefitSettings& settings) {
    return {parents_program(settings.stream_group_size), tree_cost_program(settings.stream_group_size),
            program(settings, "refit_order.cl"), program(settings, "refit.cl")};
}

std::uint64_t refit_order_bytes(const RefitSettings& settings, std::uint32_t node_count) {
    ArrayLayout layout;
    (void)cut_order(layout, settings, node_count);
    return layout.bytes();
}

RefitScratch cut_refit_scratch(ArrayLayout& layout, const RefitSettings& settings, std::uint32_t node_count) {
    // Sums of ranges and of the top in the lane shape, of slots in the group shape.
    const std::uint64_t sums = std::max<std::uint64_t>(settings.ranges + 1, slot_groups(node_count));
    RefitScratch scratch;
    scratch.before = cut_sums(layout, sums);
    scratch.after = cut_sums(layout, sums);
    return scratch;
}

std::uint64_t cost_scratch_bytes(std::uint32_t node_count) {
    ArrayLayout layout;
    (void)cut_sums(layout, slot_groups(node_count));
    return layout.bytes();
}

void launch_refit_order(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& order) {
    if (tree.node_count == 0) return;
    launcher.begin_stage("refit order", 0.0);
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(program(settings, "refit_order.cl"), name);
    };
    const OrderViews views = cut_order(order, settings, tree.node_count);
    const std::size_t groups = slot_groups(tree.node_count);
    launcher.launch(kernel("clear_arrivals"), groups, static_cast<std::uint32_t>(pairs_of(tree.node_count)),
                    views.arrivals);
    launch_parents(launcher, settings.stream_group_size, tree, views.parents);
    if (!settings.lane()) return;
    launch_on_tree(launcher, kernel("measure_subtrees"), groups, tree, views.parents, views.arrivals);
    launch_on_tree(launcher, kernel("plan_order"), 1, tree, views.arrivals, views.order, views.ranges);
    launcher.launch(kernel("write_order"), settings.ranges, tree.nodes, views.arrivals, views.order, views.ranges);
}

void launch_refit(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree,
                  const cl::Buffer& primitive_ids, const cl::Buffer& boxes, const Block& order,
                  const RefitScratch& scratch, const Block& sah) {
    const OrderViews views = cut_order(order, settings, tree.node_count);
    (settings.lane() ? refit_in_lanes : refit_in_groups)(launcher, settings, tree, primitive_ids, boxes, views,
                                                         scratch);
    const auto sums = static_cast<std::uint32_t>(settings.lane() ? settings.ranges + 1 : slot_groups(tree.node_count));
    launch_cost(launcher, settings.stream_group_size, scratch.before, sums, sah);
    launch_cost(launcher, settings.stream_group_size, scratch.after, sums, sah.behind(sizeof(float)));
}

void launch_tree_cost(Launcher& launcher, const RefitSettings& settings, const TreeNodes& tree, const Block& scratch,
                      const Block& sah) {
    launcher.begin_stage("cost", 0.0);
    ArrayLayout layout(scratch);
    const CostSums sums = cut_sums(layout, slot_groups(tree.node_count));
    launch_cost_sums(launcher, settings.stream_group_size, tree, settings.costs, sums);
    launch_cost(launcher, settings.stream_group_size, sums, static_cast<std::uint32_t>(slot_groups(tree.node_count)),
                sah);
}

}  // namespace clbvh::device
