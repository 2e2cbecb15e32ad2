#include "clbvh/device/device_refitter.hpp"

#include <utility>
#include <variant>
#include <vector>

#include "clbvh/core/error.hpp"
#include "device/api/caller_input.hpp"
#include "device/api/caller_queue.hpp"
#include "device/api/caller_tree.hpp"
#include "device/api/layout_book.hpp"
#include "device/build/bounds.hpp"
#include "device/trace/layout.hpp"
#include "device/tree/refit.hpp"
#include "metrics/check_costs.hpp"

namespace clbvh {
namespace {

using device::CallerMemory;
using device::RefitSettings;
using device::Session;

constexpr std::uint64_t kLayoutBegin = 64;

RefitSettings prepare_refitting(Session& session, const DeviceRefitterOptions& options) {
    check_costs(options.costs);
    const RefitSettings settings = device::resolve_refit_settings(session, options.shape, options.costs);
    std::vector<device::ProgramSpec> programs{
        device::bounds_program(settings),
        device::wide_program(device::resolve_layout_settings(session, settings.shape), device::WideKind::wide8)};
    for (device::ProgramSpec& program : device::refit_programs(settings))
        programs.push_back(std::move(program));
    session.prepare({programs});
    return settings;
}

/// Memory of the caller's that kernels use through views, looked at.
CallerMemory check_views(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes,
                         std::uint64_t alignment) {
    CallerMemory memory = device::examine(session, name, span, bytes);
    device::check_views_allowed(memory, alignment);
    return memory;
}

CallerMemory check_sah(const Session& session, const DeviceSpan& span, std::uint64_t floats) {
    device::check_multiple("the costs' offset", span.offset, 0, sizeof(float));
    CallerMemory memory = device::examine(session, "the costs", span, floats * sizeof(float));
    device::check_read_write(memory);
    return memory;
}

/// A layout of `tree`, whose primitives are `input`, looked at; empty where none is given.
CallerMemory check_layout(const Session& session, const DeviceBvh& tree, const CallerMemory& nodes,
                          const DeviceRefit& refit) {
    if (refit.layout.buffer == nullptr) return {};
    if (!std::holds_alternative<DeviceTriangles>(refit.input)) {
        throw Error(ErrorCode::invalid_input, "a layout holds triangles, but the primitives are boxes");
    }
    const device::WideParts parts =
        device::lay_out_wide(device::WideKind::wide8, tree.node_count, tree.reference_count);
    CallerMemory layout = device::examine(session, "the layout", refit.layout, parts.bytes);
    device::check_aligned(layout, kLayoutBegin);
    device::check_read_write(layout);
    device::check_layout_of(layout, nodes);
    return layout;
}

}  // namespace

struct CLBVH_NO_EXPORT DeviceRefitter::State {
    State(Context chosen_context, const DeviceRefitterOptions& chosen_options)
        : context(std::move(chosen_context)),
          options(chosen_options),
          settings(prepare_refitting(context.session(), options)),
          layout_settings(device::resolve_layout_settings(context.session(), settings.shape)),
          alignment(device::view_alignment(context.session())) {}

    void enqueue(std::string_view what, const device::CallerQueue& on,
                 const std::function<void(device::Launcher&)>& launch) const {
        device::enqueue_for_caller(what, context.session(), on, launch);
    }
    /// A refit's scratch: the boxes of the primitives, then the sums of the costs.
    struct Scratch {
        device::BuildBuffers bounds;
        device::RefitScratch refit;
    };
    [[nodiscard]] Scratch cut_scratch(device::ArrayLayout& layout, std::uint32_t node_count,
                                      std::uint32_t primitives) const {
        Scratch scratch;
        scratch.bounds = device::cut_bounds(layout, primitives);
        scratch.refit = device::cut_refit_scratch(layout, settings, node_count);
        return scratch;
    }
    [[nodiscard]] std::uint64_t scratch_bytes(std::uint32_t node_count, std::uint32_t primitives) const {
        device::ArrayLayout layout;
        (void)cut_scratch(layout, node_count, primitives);
        return layout.bytes();
    }
    void refit(device::Launcher& launcher, const DeviceBvh& given, const DeviceRefit& refit) const;

    Context context;
    DeviceRefitterOptions options;
    RefitSettings settings;
    device::LayoutSettings layout_settings;
    std::uint64_t alignment;
};

void DeviceRefitter::State::refit(device::Launcher& launcher, const DeviceBvh& given, const DeviceRefit& refit) const {
    const Session& session = context.session();
    const CallerMemory sah = check_sah(session, refit.sah, 2);
    const std::uint32_t primitives = device::count_of(refit.input);
    if (given.node_count == 0 || given.reference_count == 0 || primitives == 0) {
        launcher.begin_stage("refit", 0.0);
        launcher.clear_uints(sah.given.buffer, sah.given.offset, 2);
        return;
    }
    const device::CallerTree tree = device::check_tree(session, given, alignment);
    const CallerMemory ids = check_views(session, "the primitive ids", given.primitive_ids,
                                         sizeof(cl_uint) * std::uint64_t{given.reference_count}, alignment);
    const CallerMemory order = check_views(session, "the order", refit.order,
                                           device::refit_order_bytes(settings, given.node_count), alignment);
    const CallerMemory scratch =
        check_views(session, "the scratch", refit.scratch, scratch_bytes(given.node_count, primitives), alignment);
    const device::CallerInput input = device::check_input(session, refit.input);
    const CallerMemory traced = check_layout(session, given, tree.nodes, refit);
    device::check_apart({tree.nodes, ids, order, scratch, sah, traced, input.vertices, tree.active_count});
    device::check_apart({tree.nodes, ids, order, scratch, sah, traced, input.indices, tree.active_count});
    for (const CallerMemory& memory : {input.vertices, input.indices, tree.active_count, sah, traced})
        device::check_in_other_buffer(memory, {tree.nodes, ids, order, scratch});
    device::ArrayLayout layout(scratch.place);
    const Scratch views = cut_scratch(layout, given.node_count, primitives);
    launcher.begin_stage("refit", 0.0);
    device::launch_bounds(launcher, settings, views.bounds, input.mesh);
    for (const CallerMemory& written : {tree.nodes, scratch})
        device::note_written(written);
    const cl::Buffer ids_view = device::view_of(ids.place, 0, ids.bytes);
    device::launch_refit(launcher, settings, tree.tree, ids_view, views.bounds.boxes, order.place, views.refit,
                         sah.given);
    if (!traced.is_there()) return;
    device::note_layout(traced, tree.nodes);
    device::launch_wide_refit(
        launcher, layout_settings,
        {given.node_count, given.reference_count, {tree.tree.nodes}, {ids_view}, {}, input.mesh, traced.given});
}

DeviceRefitter::DeviceRefitter(Context context, const DeviceRefitterOptions& options)
    : state_(std::make_unique<State>(std::move(context), options)) {}
DeviceRefitter::DeviceRefitter(DeviceRefitter&&) noexcept = default;
DeviceRefitter& DeviceRefitter::operator=(DeviceRefitter&&) noexcept = default;
DeviceRefitter::~DeviceRefitter() = default;

DeviceRefitSizes DeviceRefitter::sizes(std::uint32_t node_count, std::uint32_t primitive_count) const noexcept {
    return {device::refit_order_bytes(state_->settings, node_count), state_->scratch_bytes(node_count, primitive_count),
            device::cost_scratch_bytes(node_count)};
}

std::uint64_t DeviceRefitter::alignment() const noexcept {
    return state_->alignment;
}

void DeviceRefitter::enqueue_order(cl_command_queue queue, const DeviceBvh& tree, const DeviceSpan& order,
                                   EventList wait_list, cl_event* event) {
    const State& state = *state_;
    const Session& session = state.context.session();
    state.enqueue("enqueuing an order", {queue, wait_list, event}, [&](device::Launcher& launcher) {
        if (tree.node_count == 0) return;
        const device::CallerTree checked = device::check_tree(session, tree, state.alignment);
        const CallerMemory out = check_views(
            session, "the order", order, device::refit_order_bytes(state.settings, tree.node_count), state.alignment);
        device::check_apart({checked.nodes, out, checked.active_count});
        device::check_in_other_buffer(checked.active_count, {checked.nodes, out});
        device::launch_refit_order(launcher, state.settings, checked.tree, out.place);
    });
}

void DeviceRefitter::enqueue(cl_command_queue queue, const DeviceBvh& tree, const DeviceRefit& refit,
                             EventList wait_list, cl_event* event) {
    const State& state = *state_;
    state.enqueue("enqueuing a refit", {queue, wait_list, event},
                  [&](device::Launcher& launcher) { state.refit(launcher, tree, refit); });
}

void DeviceRefitter::enqueue_cost(cl_command_queue queue, const DeviceBvh& tree, const DeviceSpan& scratch,
                                  const DeviceSpan& sah, EventList wait_list, cl_event* event) {
    const State& state = *state_;
    const Session& session = state.context.session();
    state.enqueue("enqueuing a cost", {queue, wait_list, event}, [&](device::Launcher& launcher) {
        const CallerMemory cost = check_sah(session, sah, 1);
        if (tree.node_count == 0) {
            launcher.begin_stage("cost", 0.0);
            launcher.clear_uints(cost.given.buffer, cost.given.offset, 1);
            return;
        }
        const device::CallerTree checked = device::check_tree(session, tree, state.alignment);
        const CallerMemory rest =
            check_views(session, "the scratch", scratch, device::cost_scratch_bytes(tree.node_count), state.alignment);
        device::check_apart({checked.nodes, rest, cost, checked.active_count});
        for (const CallerMemory& memory : {checked.active_count, cost})
            device::check_in_other_buffer(memory, {checked.nodes, rest});
        device::launch_tree_cost(launcher, state.settings, checked.tree, rest.place, cost.given);
    });
}

const DeviceRefitterOptions& DeviceRefitter::options() const noexcept {
    return state_->options;
}
const Context& DeviceRefitter::context() const noexcept {
    return state_->context;
}
Shape DeviceRefitter::shape() const noexcept {
    return state_->settings.shape;
}

}  // namespace clbvh
