#include "clbvh/device/device_builder.hpp"

#include <algorithm>
#include <string>

#include "catalog/builder_rows.hpp"
#include "catalog/device_configs.hpp"
#include "catalog/device_optimizers.hpp"
#include "catalog/optimizer_rows.hpp"
#include "clbvh/catalog.hpp"
#include "clbvh/core/error.hpp"
#include "clbvh/core/mesh.hpp"
#include "device/api/caller_input.hpp"
#include "device/api/caller_queue.hpp"
#include "device/api/caller_tree.hpp"
#include "device/api/layout_book.hpp"
#include "device/build/pipeline.hpp"

namespace clbvh {
namespace {

using device::Block;
using device::CallerMemory;

/// A preset may ask for what its caller did not name.
void check_preset(std::string_view id, const BuilderRow& row, const BuildOptions& given) {
    const PresetInfo* const preset = find_preset(id);
    if (preset == nullptr || preset->max_leaf_size == 0 || given.max_leaf_size != 0) return;
    throw Error(ErrorCode::unsupported,
                "the preset " + std::string(id) + " merges leaves, which is the host's work; DeviceBuilder takes " +
                    std::string(row.info.id) + " with optimizers " + std::string(preset->optimizers));
}

/// The row of `id`, where it can build with these options on a device and with nothing else.
const BuilderRow& device_row(std::string_view id, const BuildOptions& given) {
    const BuilderRow& row = find_builder_row(id);
    const BuildOptions options = with_preset(id, given);
    check_options(options);
    if (row.info.kind == BuilderKind::host) {
        throw Error(ErrorCode::unsupported, std::string(id) + " runs on the host; DeviceBuilder takes device builders");
    }
    if (row.device_algorithm->uses_host) {
        throw Error(ErrorCode::unsupported, std::string(id) +
                                                " builds the top of its tree on the host; DeviceBuilder "
                                                "takes builders that need none, such as lbvh and hploc");
    }
    check_preset(id, row, given);
    device::check_device_options("DeviceBuilder", options);
    check_device_optimizers(options.optimizers);
    return row;
}

/// A build in the caller's memory, looked at.
struct CheckedBuild {
    device::DeviceMesh mesh;  ///< without primitives nothing is built
    Block nodes, primitive_ids, scratch;
    Block active_count;  ///< where to put the number of active primitives; may have no buffer
};

}  // namespace

struct CLBVH_NO_EXPORT DeviceBuilder::State {
    State(std::string_view builder_id, Context chosen_context, const BuildOptions& chosen_options)
        : options(with_preset(builder_id, chosen_options)),
          row(device_row(builder_id, chosen_options)),
          context(std::move(chosen_context)),
          settings(device::prepare_pipeline(context.session(), *row.device_algorithm,
                                            device_configs_for(row.info.id, options))),
          optimizers(make_optimizer_chain(context.session(), options)),
          alignment(device::view_alignment(context.session())) {}

    [[nodiscard]] device::MemoryPlan plan(std::uint32_t primitives) const {
        return device::plan_pipeline(*row.device_algorithm, settings, primitives);
    }
    [[nodiscard]] DeviceBuildSizes sizes(std::uint32_t primitives) const {
        if (primitives == 0) return {};
        const device::MemoryPlan planned = plan(primitives);
        return {planned.nodes, planned.primitive_ids,
                count_bytes() + std::max(planned.scratch_bytes(), optimizers.scratch_bytes(2 * primitives))};
    }
    /// At the beginning of the scratch: the number of leaves, for optimisers, whose scratch is the builder's again.
    [[nodiscard]] std::uint64_t count_bytes() const { return optimizers.empty() ? 0 : device::kViewAlignment; }
    [[nodiscard]] bool fits(std::uint32_t primitives) const {
        const DeviceBuildSizes needed = sizes(primitives);
        return std::max({needed.nodes, needed.primitive_ids, needed.scratch}) <= context.device().max_allocation_bytes;
    }
    [[nodiscard]] std::uint32_t most_primitives() const;
    [[nodiscard]] CheckedBuild check(const DeviceInput& input, const DeviceSpan& scratch,
                                     const DeviceResult& result) const;
    void launch(device::Launcher& launcher, const CheckedBuild& build) const;
    void launch_optimizers(device::Launcher& launcher, const CheckedBuild& build) const;

    BuildOptions options;
    const BuilderRow& row;
    Context context;
    device::BuildSettings settings;
    device::OptimizerChain optimizers;
    std::uint64_t alignment;
};

std::uint32_t DeviceBuilder::State::most_primitives() const {
    std::uint32_t fitting = 0, beyond = static_cast<std::uint32_t>(kMaxPrimitives) + 1;
    while (beyond - fitting > 1) {
        const std::uint32_t middle = fitting + (beyond - fitting) / 2;
        (fits(middle) ? fitting : beyond) = middle;
    }
    return fitting;
}

CheckedBuild DeviceBuilder::State::check(const DeviceInput& input, const DeviceSpan& scratch,
                                         const DeviceResult& result) const {
    const device::Session& session = context.session();
    const std::uint32_t count = device::count_of(input);
    CheckedBuild build;
    const CallerMemory active_count = device::examine_active_count(session, result.active_count);
    build.active_count = active_count.given;
    if (count == 0) return build;
    const DeviceBuildSizes needed = sizes(count);
    const device::CallerInput checked = device::check_input(session, input);
    const CallerMemory nodes = device::examine(session, "the nodes", result.nodes, needed.nodes);
    const CallerMemory ids = device::examine(session, "the primitive ids", result.primitive_ids, needed.primitive_ids);
    const CallerMemory rest = device::examine(session, "the scratch", scratch, needed.scratch);
    for (const CallerMemory& memory : {nodes, ids, rest})
        device::check_views_allowed(memory, alignment);
    device::check_apart({nodes, ids, rest, checked.vertices, active_count});
    device::check_apart({nodes, ids, rest, checked.indices, active_count});
    for (const CallerMemory& memory : {checked.vertices, checked.indices})
        device::check_in_other_buffer(memory, {nodes, ids, rest});
    for (const CallerMemory& written : {nodes, ids, rest})
        device::note_written(written);
    build.mesh = checked.mesh;
    build.nodes = nodes.place;
    build.primitive_ids = ids.place;
    build.scratch = rest.place;
    return build;
}

void DeviceBuilder::State::launch(device::Launcher& launcher, const CheckedBuild& build) const {
    if (build.mesh.primitive_count == 0) {
        if (build.active_count.is_there())
            launcher.clear_uints(build.active_count.buffer, build.active_count.offset, 1);
        return;
    }
    const device::MemoryPlan planned = plan(build.mesh.primitive_count);
    const device::BuildBuffers buffers = device::cut_views(
        device::cut_scratch(build.nodes, build.primitive_ids, build.scratch.behind(count_bytes()), planned), planned);
    device::enqueue_pipeline(launcher, *row.device_algorithm, settings, build.mesh, buffers);
    const auto copy_count = [&](const cl::Buffer& from, const Block& to) {
        launcher.copy_uint(from, 0, to.buffer, to.offset);
    };
    if (build.active_count.is_there()) copy_count(buffers.primitive_count, build.active_count);
    if (optimizers.empty()) return;
    copy_count(buffers.leaf_count, build.scratch);
    launch_optimizers(launcher, build);
}

void DeviceBuilder::State::launch_optimizers(device::Launcher& launcher, const CheckedBuild& build) const {
    const std::uint32_t node_count = 2 * build.mesh.primitive_count;
    const device::TreeNodes tree{device::view_of(build.nodes, 0, sizeof(Node) * std::uint64_t{node_count}),
                                 node_count,
                                 {device::view_of(build.scratch, 0, sizeof(cl_uint))}};
    optimizers.launch(launcher, tree, build.scratch.behind(count_bytes()), 0.95);
}

DeviceBuilder::DeviceBuilder(std::string_view builder_id, Context context, const BuildOptions& options)
    : state_(std::make_unique<State>(builder_id, std::move(context), options)) {}
DeviceBuilder::DeviceBuilder(DeviceBuilder&&) noexcept = default;
DeviceBuilder& DeviceBuilder::operator=(DeviceBuilder&&) noexcept = default;
DeviceBuilder::~DeviceBuilder() = default;

DeviceBuildSizes DeviceBuilder::sizes(std::uint64_t primitive_count) const {
    if (primitive_count > kMaxPrimitives) {
        throw Error(ErrorCode::unsupported, std::to_string(primitive_count) + " primitives are more than the " +
                                                std::to_string(kMaxPrimitives) + " that a tree can hold");
    }
    const auto count = static_cast<std::uint32_t>(primitive_count);
    if (!state_->fits(count)) {
        const DeviceInfo& info = state_->context.device();
        throw Error(ErrorCode::unsupported,
                    std::to_string(count) + " primitives are too many for " + info.name + ", which allocates at most " +
                        std::to_string(info.max_allocation_bytes) + " bytes at once: enough for " +
                        std::to_string(state_->most_primitives()) + "; build in parts");
    }
    return state_->sizes(count);
}

std::uint64_t DeviceBuilder::alignment() const noexcept {
    return state_->alignment;
}

void DeviceBuilder::enqueue(cl_command_queue queue, const DeviceInput& input, const DeviceSpan& scratch,
                            const DeviceResult& result, EventList wait_list, cl_event* event) {
    const State& state = *state_;
    device::enqueue_for_caller("enqueuing a build", state.context.session(), {queue, wait_list, event},
                               [&](device::Launcher& launcher) {
                                   (void)sizes(device::count_of(input));
                                   state.launch(launcher, state.check(input, scratch, result));
                               });
}

const BuilderInfo& DeviceBuilder::info() const noexcept {
    return state_->row.info;
}
const BuildOptions& DeviceBuilder::options() const noexcept {
    return state_->options;
}
const Context& DeviceBuilder::context() const noexcept {
    return state_->context;
}
Shape DeviceBuilder::shape() const noexcept {
    return state_->settings.shape;
}

}  // namespace clbvh
