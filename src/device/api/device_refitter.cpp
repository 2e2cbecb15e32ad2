#include "clbvh/device/device_refitter.hpp"

#include <utility>

#include "device/api/caller_input.hpp"
#include "device/api/caller_tree.hpp"
#include "device/tree/refit.hpp"
#include "metrics/check_costs.hpp"

namespace clbvh {
namespace {

using device::Block;
using device::CallerMemory;
using device::RefitSettings;
using device::Session;

RefitSettings prepare_refitting(Session& session, const DeviceRefitterOptions& options) {
    check_costs(options.costs);
    const RefitSettings settings = device::resolve_refit_settings(session, options.shape, options.costs);
    session.prepare({device::refit_programs(settings)});
    return settings;
}

/// Memory of the caller's that kernels use through views, looked at.
CallerMemory check_views(const Session& session, std::string_view name, const DeviceSpan& span, std::uint64_t bytes,
                         std::uint64_t alignment) {
    CallerMemory memory = device::look_at(session, name, span, bytes);
    device::check_views_allowed(memory, alignment);
    return memory;
}

CallerMemory check_sah(const Session& session, const DeviceSpan& span, std::uint64_t floats) {
    device::check_multiple("the costs' offset", span.offset, 0, sizeof(float));
    CallerMemory memory = device::look_at(session, "the costs", span, floats * sizeof(float));
    device::check_read_write(memory);
    return memory;
}

Block block_of(const CallerMemory& memory) {
    return {memory.buffer, memory.offset};
}

}  // namespace

struct CLBVH_NO_EXPORT DeviceRefitter::State {
    State(Context chosen_context, const DeviceRefitterOptions& chosen_options)
        : context(std::move(chosen_context)),
          options(chosen_options),
          settings(prepare_refitting(context.session(), options)),
          alignment(device::view_alignment(context.session())) {}

    /// Calls `launch` with a launcher on `queue` behind `wait_list`, where there are nodes, and hands over the end.
    template <typename Launch>
    void enqueue(std::string_view what, cl_command_queue queue, std::span<const cl_event> wait_list, cl_event* event,
                 const Launch& launch) const {
        device::with_opencl_errors(what, [&] {
            Session& session = context.session();
            device::check_queue(session, queue);
            device::Launcher launcher(session, cl::CommandQueue(queue, true), device::copy_events(wait_list));
            launch(session, launcher);
            launcher.hand_over_end(event);
        });
    }
    void refit(Session& session, device::Launcher& launcher, const DeviceNodes& given, const DeviceRefit& refit) const;

    Context context;
    DeviceRefitterOptions options;
    RefitSettings settings;
    std::uint64_t alignment;
};

void DeviceRefitter::State::refit(Session& session, device::Launcher& launcher, const DeviceNodes& given,
                                  const DeviceRefit& refit) const {
    const CallerMemory sah = check_sah(session, refit.sah, 2);
    const std::uint32_t primitives = device::count_of(refit.input);
    if (given.node_count == 0 || refit.reference_count == 0 || primitives == 0) {
        launcher.begin_stage("refit", 0.0);
        launcher.clear_uints(sah.buffer, sah.offset, 2);
        return;
    }
    const device::CallerTree tree = device::check_tree(session, given, alignment);
    const CallerMemory ids = check_views(session, "the primitive ids", refit.primitive_ids,
                                         sizeof(cl_uint) * std::uint64_t{refit.reference_count}, alignment);
    const CallerMemory order = check_views(session, "the order", refit.order,
                                           device::refit_order_bytes(settings, given.node_count), alignment);
    const CallerMemory scratch =
        check_views(session, "the scratch", refit.scratch,
                    device::refit_scratch_bytes(settings, given.node_count, primitives), alignment);
    const device::CallerInput input = device::check_input(session, refit.input);
    device::check_apart({tree.nodes, ids, order, scratch, sah, input.vertices, tree.active_count});
    device::check_apart({tree.nodes, ids, order, scratch, sah, input.indices, tree.active_count});
    for (const CallerMemory& memory : {input.vertices, input.indices, tree.active_count, sah})
        device::check_not_cut(memory, {tree.nodes, ids, order, scratch});
    device::launch_refit(launcher, settings, tree.tree, device::view_of(ids.place, 0, ids.bytes), input.mesh,
                         order.place, scratch.place, block_of(sah));
}

DeviceRefitter::DeviceRefitter(Context context, const DeviceRefitterOptions& options)
    : state_(std::make_unique<State>(std::move(context), options)) {}
DeviceRefitter::DeviceRefitter(DeviceRefitter&&) noexcept = default;
DeviceRefitter& DeviceRefitter::operator=(DeviceRefitter&&) noexcept = default;
DeviceRefitter::~DeviceRefitter() = default;

DeviceRefitSizes DeviceRefitter::sizes(std::uint32_t node_count, std::uint32_t primitive_count) const noexcept {
    return {device::refit_order_bytes(state_->settings, node_count),
            device::refit_scratch_bytes(state_->settings, node_count, primitive_count),
            device::quality_scratch_bytes(node_count)};
}

std::uint64_t DeviceRefitter::alignment() const noexcept {
    return state_->alignment;
}

void DeviceRefitter::enqueue_order(cl_command_queue queue, const DeviceNodes& tree, const DeviceSpan& order,
                                   std::span<const cl_event> wait_list, cl_event* event) {
    const State& state = *state_;
    state.enqueue("enqueuing an order", queue, wait_list, event, [&](Session& session, device::Launcher& launcher) {
        if (tree.node_count == 0) return;
        const device::CallerTree checked = device::check_tree(session, tree, state.alignment);
        const CallerMemory out = check_views(
            session, "the order", order, device::refit_order_bytes(state.settings, tree.node_count), state.alignment);
        device::check_apart({checked.nodes, out, checked.active_count});
        device::check_not_cut(checked.active_count, {checked.nodes, out});
        device::launch_refit_order(launcher, state.settings, checked.tree, out.place);
    });
}

void DeviceRefitter::enqueue(cl_command_queue queue, const DeviceNodes& tree, const DeviceRefit& refit,
                             std::span<const cl_event> wait_list, cl_event* event) {
    const State& state = *state_;
    state.enqueue("enqueuing a refit", queue, wait_list, event,
                  [&](Session& session, device::Launcher& launcher) { state.refit(session, launcher, tree, refit); });
}

void DeviceRefitter::enqueue_quality(cl_command_queue queue, const DeviceNodes& tree, const DeviceSpan& scratch,
                                     const DeviceSpan& sah, std::span<const cl_event> wait_list, cl_event* event) {
    const State& state = *state_;
    state.enqueue("enqueuing a cost", queue, wait_list, event, [&](Session& session, device::Launcher& launcher) {
        const CallerMemory cost = check_sah(session, sah, 1);
        if (tree.node_count == 0) {
            launcher.begin_stage("quality", 0.0);
            launcher.clear_uints(cost.buffer, cost.offset, 1);
            return;
        }
        const device::CallerTree checked = device::check_tree(session, tree, state.alignment);
        const CallerMemory rest = check_views(session, "the scratch", scratch,
                                              device::quality_scratch_bytes(tree.node_count), state.alignment);
        device::check_apart({checked.nodes, rest, cost, checked.active_count});
        for (const CallerMemory& memory : {checked.active_count, cost})
            device::check_not_cut(memory, {checked.nodes, rest});
        device::launch_quality(launcher, state.settings, checked.tree, rest.place, block_of(cost));
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
