#include "clbvh/device/device_optimizer.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "catalog/device_optimizers.hpp"
#include "clbvh/core/error.hpp"
#include "core/memory_errors.hpp"
#include "core/tree_walk.hpp"
#include "device/api/caller_queue.hpp"
#include "device/api/caller_tree.hpp"
#include "device/api/layout_book.hpp"
#include "device/opencl/device_memory.hpp"
#include "device/tree/optimize.hpp"

namespace clbvh {
namespace {

using device::CallerMemory;

void check_fits(const device::Session& session, std::uint32_t node_count, std::uint64_t bytes) {
    const DeviceInfo& info = session.info();
    if (bytes <= info.max_allocation_bytes) return;
    throw Error(ErrorCode::unsupported, "a tree of " + std::to_string(node_count) + " nodes is too large for " +
                                            info.name + ": it takes " + std::to_string(bytes) +
                                            " bytes at once, and the device allocates at most " +
                                            std::to_string(info.max_allocation_bytes) + "; optimize it on the host");
}

/// Whether the nodes 2 * p and 2 * p + 1 belong to the tree, for each p; the root's pair does.
std::vector<bool> pairs_in_use(const Bvh& tree) {
    TreeWalk walk{std::span<const Node>(tree.nodes)};
    while (walk.next()) {
    }
    if (walk.failed()) throw Error(ErrorCode::invalid_input, "the nodes form no tree: " + walk.fault());
    return std::move(walk).take_pairs();
}

/// The nodes as a device takes them: zero where none is in use.
std::vector<Node> without_strays(const Bvh& tree, const std::vector<bool>& in_use) {
    std::vector<Node> nodes = tree.nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (!in_use[i / 2] || i == 1) nodes[i] = {};
    }
    return nodes;
}

}  // namespace

struct CLBVH_NO_EXPORT DeviceOptimizer::State {
    State(std::string_view ids, Context chosen_context, const DeviceOptimizerOptions& chosen_options)
        : context(std::move(chosen_context)),
          options(chosen_options),
          optimizers(context.session(), find_device_optimizers(ids), options),
          alignment(device::view_alignment(context.session())) {}

    [[nodiscard]] std::uint64_t scratch_bytes(std::uint32_t node_count) const {
        const std::uint64_t bytes = optimizers.scratch_bytes(node_count);
        check_fits(context.session(), node_count, std::max(bytes, sizeof(Node) * std::uint64_t{node_count}));
        return bytes;
    }
    /// Throws where something is wrong with the arguments.
    void launch(device::Launcher& launcher, const DeviceBvh& tree, const DeviceSpan& scratch) const;
    void run(std::vector<Node>& nodes) const;

    Context context;
    DeviceOptimizerOptions options;
    device::OptimizerChain optimizers;
    std::uint64_t alignment;
};

void DeviceOptimizer::State::launch(device::Launcher& launcher, const DeviceBvh& tree,
                                    const DeviceSpan& scratch) const {
    const device::Session& session = context.session();
    const std::uint64_t scratch_needed = scratch_bytes(tree.node_count);
    if (tree.node_count == 0) return;
    const device::CallerTree checked = device::check_tree(session, tree, alignment);
    CallerMemory rest;
    if (scratch_needed > 0) {
        rest = device::examine(session, "the scratch", scratch, scratch_needed);
        device::check_views_allowed(rest, alignment);
    }
    device::check_apart({checked.nodes, rest, checked.active_count});
    device::check_in_other_buffer(checked.active_count, {checked.nodes, rest});
    for (const CallerMemory& written : {checked.nodes, rest})
        device::note_written(written);
    optimizers.launch(launcher, checked.tree, rest.place, 0.0);
}

void DeviceOptimizer::State::run(std::vector<Node>& nodes) const {
    device::with_opencl_errors("optimizing a tree", [&] {
        device::Session& session = context.session();
        const auto node_count = static_cast<std::uint32_t>(nodes.size());
        const std::uint64_t bytes = sizeof(Node) * std::uint64_t{node_count};
        const std::uint64_t scratch = scratch_bytes(node_count);
        if (scratch == 0) return;
        const device::TreeNodes tree{device::allocate_buffer(session, bytes), node_count, {}};
        const device::Block rest{device::allocate_buffer(session, scratch)};
        session.queue().enqueueWriteBuffer(tree.nodes, CL_TRUE, 0, bytes, nodes.data());
        device::Launcher launcher(session, session.queue(), {});
        optimizers.launch(launcher, tree, rest, 0.0);
        session.queue().finish();
        session.queue().enqueueReadBuffer(tree.nodes, CL_TRUE, 0, bytes, nodes.data());
    });
}

DeviceOptimizer::DeviceOptimizer(std::string_view ids, Context context, const DeviceOptimizerOptions& options)
    : state_(std::make_unique<State>(ids, std::move(context), options)) {}
DeviceOptimizer::DeviceOptimizer(DeviceOptimizer&&) noexcept = default;
DeviceOptimizer& DeviceOptimizer::operator=(DeviceOptimizer&&) noexcept = default;
DeviceOptimizer::~DeviceOptimizer() = default;

std::uint64_t DeviceOptimizer::scratch_bytes(std::uint32_t node_count) const {
    return state_->scratch_bytes(node_count);
}

std::uint64_t DeviceOptimizer::alignment() const noexcept {
    return state_->alignment;
}

void DeviceOptimizer::enqueue(cl_command_queue queue, const DeviceBvh& tree, const DeviceSpan& scratch,
                              EventList wait_list, cl_event* event) {
    const State& state = *state_;
    device::enqueue_for_caller("enqueuing optimizers", state.context.session(), {queue, wait_list, event},
                               [&](device::Launcher& launcher) { state.launch(launcher, tree, scratch); });
}

Bvh DeviceOptimizer::optimize(Bvh tree) {
    return with_memory_errors("a copy of the tree", [&] {
        const std::vector<bool> in_use = pairs_in_use(tree);
        if (tree.empty() || tree.nodes[0].is_leaf()) return std::move(tree);
        std::vector<Node> nodes = without_strays(tree, in_use);
        state_->run(nodes);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (in_use[i / 2] && i != 1) tree.nodes[i] = nodes[i];
        }
        return std::move(tree);
    });
}

const DeviceOptimizerOptions& DeviceOptimizer::options() const noexcept {
    return state_->options;
}
const Context& DeviceOptimizer::context() const noexcept {
    return state_->context;
}
Shape DeviceOptimizer::shape() const noexcept {
    return state_->optimizers.settings().shape;
}

}  // namespace clbvh
