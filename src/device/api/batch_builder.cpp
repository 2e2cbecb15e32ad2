#include "clbvh/device/batch_builder.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "catalog/builder_rows.hpp"
#include "catalog/device_configs.hpp"
#include "clbvh/core/error.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "core/primitive_access.hpp"
#include "device/api/caller_input.hpp"
#include "device/api/caller_queue.hpp"
#include "device/api/layout_book.hpp"
#include "device/build/batch.hpp"
#include "device/opencl/device_memory.hpp"

namespace clbvh {
namespace {

using device::BatchJob;
using device::BatchPlan;
using device::CallerMemory;
using device::KeptBuffer;
using device::Session;

device::BuildSettings resolve_batch_settings(const BuildOptions& options, Session& session) {
    check_options(options);
    device::check_device_options("BatchBuilder", options);
    if (!options.optimizers.empty()) {
        throw Error(ErrorCode::unsupported,
                    "optimizers work on one tree at a time, which BatchBuilder leaves out; use DeviceBuilder, or leave "
                    "them alone");
    }
    const BuilderRow& plocpp = find_builder_row("plocpp");
    const device::BuildSettings settings =
        device::resolve_settings(*plocpp.device_algorithm, device_configs_for(plocpp.info.id, options), session);
    if (options.device.morton_code == MortonCode::extended || !settings.packed_keys()) {
        throw Error(ErrorCode::unsupported,
                    "batches are sorted by 3D Morton codes of 33 or 44 bits; leave morton_code and code_bits alone");
    }
    if (!settings.lane() && options.ploc.work_group_size > device::kLargestBatchGroup) {
        throw Error(ErrorCode::unsupported, "work_group_size " + std::to_string(options.ploc.work_group_size) +
                                                " is more than the " + std::to_string(device::kLargestBatchGroup) +
                                                " work items that a tree of a batch gets");
    }
    const device::ProgramSpec program = device::batch_program(settings);
    session.prepare({std::span(&program, 1)});
    return settings;
}

/// Where each mesh's part of the arrays begins.
struct Placement {
    std::vector<BatchRange> ranges;
    std::uint64_t vertices = 0, triangles = 0;
};

/// Checks the meshes and lays them out one behind the other.
Placement place_meshes(std::span<const MeshView> meshes) {
    constexpr std::uint64_t most_vertices = 0xffffffffu;
    Placement placement;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const MeshView& mesh = meshes[i];
        const auto refuse = [i](ErrorCode code, const std::string& why) {
            throw Error(code, "mesh " + std::to_string(i) + ": " + why);
        };
        try {
            static_cast<void>(check_mesh(mesh));
        } catch (const Error& error) {
            refuse(error.code(), error.what());
        }
        if (mesh.vertex_count > most_vertices - placement.vertices)
            refuse(ErrorCode::unsupported, "the vertices up to here are 2^32 or more; build in parts");
        placement.ranges.push_back({static_cast<std::uint32_t>(placement.triangles),
                                    static_cast<std::uint32_t>(mesh.triangle_count),
                                    static_cast<std::uint32_t>(placement.vertices)});
        placement.vertices += mesh.vertex_count;
        placement.triangles += mesh.triangle_count;
        if (placement.triangles > kMaxPrimitives) {
            refuse(ErrorCode::unsupported,
                   "the triangles up to here are more than " + std::to_string(kMaxPrimitives) + "; build in parts");
        }
    }
    return placement;
}

/// A buffer that the host may use until this goes.
class Mapped {
public:
    Mapped(cl::CommandQueue queue, cl::Buffer buffer, cl_map_flags flags, std::uint64_t bytes)
        : queue_(std::move(queue)),
          buffer_(std::move(buffer)),
          data_(queue_.enqueueMapBuffer(buffer_, CL_TRUE, flags, 0, bytes)) {}
    Mapped(const Mapped&) = delete;
    Mapped& operator=(const Mapped&) = delete;
    ~Mapped() { clEnqueueUnmapMemObject(queue_(), buffer_(), data_, 0, nullptr, nullptr); }

    template <typename T>
    [[nodiscard]] T* as() const noexcept {
        return static_cast<T*>(data_);
    }

private:
    cl::CommandQueue queue_;
    cl::Buffer buffer_;
    void* data_;
};

void copy_vertices(const MeshView& mesh, Vec3* to) {
    if (mesh.vertex_stride == sizeof(Vec3) && mesh.vertex_count > 0) {
        std::memcpy(static_cast<void*>(to), mesh.vertices, mesh.vertex_count * sizeof(Vec3));
        return;
    }
    for (std::uint64_t i = 0; i < mesh.vertex_count; ++i)
        to[i] = mesh.vertex(i);
}

void copy_triangles(const MeshView& mesh, Triangle* to) {
    with_triangles(mesh, [to](const auto& triangles) {
        for (std::uint64_t i = 0; i < triangles.count; ++i)
            for (std::size_t corner = 0; corner < 3; ++corner)
                to[i][corner] = static_cast<std::uint32_t>(triangles.index(i, corner));
    });
}

void clear(std::vector<Bvh>& trees, std::span<const MeshView> meshes) {
    for (std::size_t i = 0; i < meshes.size(); ++i)
        trees[i].primitive_count = meshes[i].triangle_count;
}

}  // namespace

struct CLBVH_NO_EXPORT BatchBuilder::State {
    State(Context chosen_context, BuildOptions chosen_options)
        : context(std::move(chosen_context)),
          options(std::move(chosen_options)),
          settings(resolve_batch_settings(options, context.session())),
          alignment(device::view_alignment(context.session())) {}

    [[nodiscard]] std::uint64_t largest_buffer(std::uint64_t primitives, std::uint64_t trees) const {
        const BatchPlan plan = device::plan_batch(primitives, trees);
        return std::max({plan.nodes, plan.scratch, plan.active_counts});
    }
    void check_size(std::uint64_t primitives, std::uint64_t trees) const;
    [[nodiscard]] BatchJob check(const DeviceInput& input, const DeviceBatch& batch, const DeviceSpan& rest,
                                 const DeviceResult& result) const;
    [[nodiscard]] BatchJob reserve(const Placement& placement, const BatchPlan& plan);
    void upload(std::span<const MeshView> meshes, const Placement& placement, const BatchJob& job) const;
    void download(const Placement& placement, const BatchPlan& plan, const BatchJob& job,
                  std::vector<Bvh>& trees) const;
    std::vector<Bvh> build(std::span<const MeshView> meshes, BuildStats* stats);

    Context context;
    BuildOptions options;
    device::BuildSettings settings;
    std::uint64_t alignment;
    KeptBuffer vertices, triangles, ranges, nodes, primitive_ids, active_counts, scratch;
};

void BatchBuilder::State::check_size(std::uint64_t primitives, std::uint64_t trees) const {
    const std::uint64_t most = context.device().max_allocation_bytes;
    if (primitives <= kMaxPrimitives && largest_buffer(primitives, trees) <= most) return;
    throw Error(ErrorCode::unsupported,
                std::to_string(trees) + " trees over " + std::to_string(primitives) + " primitives need a buffer of " +
                    std::to_string(largest_buffer(primitives, trees)) + " bytes, but " + context.device().name +
                    " allocates at most " + std::to_string(most) + " at once, and a batch takes at most " +
                    std::to_string(kMaxPrimitives) + " primitives; build in parts");
}

BatchJob BatchBuilder::State::check(const DeviceInput& input, const DeviceBatch& batch, const DeviceSpan& rest,
                                    const DeviceResult& result) const {
    const Session& session = context.session();
    const std::uint32_t primitives = device::count_of(input);
    check_size(primitives, batch.tree_count);
    const BatchPlan plan = device::plan_batch(primitives, batch.tree_count);
    const device::CallerInput checked = device::check_input(session, input);
    device::check_multiple("the ranges' offset", batch.ranges.offset, 0, sizeof(cl_uint));
    const CallerMemory table =
        device::examine(session, "the ranges", batch.ranges, batch.tree_count * std::uint64_t{sizeof(BatchRange)});
    const CallerMemory nodes_memory = device::examine(session, "the nodes", result.nodes, plan.nodes);
    const CallerMemory ids = device::examine(session, "the primitive ids", result.primitive_ids, plan.primitive_ids);
    const CallerMemory counts = device::examine(session, "the active count", result.active_count, plan.active_counts);
    const CallerMemory work = device::examine(session, "the scratch", rest, plan.scratch);
    for (const CallerMemory& memory : {nodes_memory, ids, counts, work})
        device::check_views_allowed(memory, alignment);
    device::check_apart({nodes_memory, ids, counts, work, table, checked.vertices});
    device::check_apart({nodes_memory, ids, counts, work, table, checked.indices});
    device::check_readable(table);
    for (const CallerMemory& memory : {checked.vertices, checked.indices, table})
        device::check_in_other_buffer(memory, {nodes_memory, ids, counts, work});
    for (const CallerMemory& written : {nodes_memory, ids, work})
        device::note_written(written);
    BatchJob job;
    job.mesh = checked.mesh;
    job.tree_count = batch.tree_count;
    job.ranges = table.given;
    job.nodes = nodes_memory.place;
    job.primitive_ids = ids.place;
    job.active_counts = counts.place;
    job.scratch = work.place;
    return job;
}

BatchJob BatchBuilder::State::reserve(const Placement& placement, const BatchPlan& plan) {
    const Session& session = context.session();
    BatchJob job;
    job.mesh.form = device::InputForm::indexed_32;
    job.mesh.primitive_count = job.mesh.active_count = static_cast<std::uint32_t>(placement.triangles);
    job.mesh.vertices = {vertices.reserve(session, placement.vertices * sizeof(Vec3))};
    job.mesh.indices = {triangles.reserve(session, placement.triangles * sizeof(Triangle))};
    job.mesh.vertex_stride = sizeof(Vec3);
    job.mesh.index_stride = sizeof(Triangle);
    job.tree_count = static_cast<std::uint32_t>(placement.ranges.size());
    job.ranges = {ranges.reserve(session, placement.ranges.size() * sizeof(BatchRange))};
    job.nodes = {nodes.reserve(session, plan.nodes)};
    job.primitive_ids = {primitive_ids.reserve(session, plan.primitive_ids)};
    job.active_counts = {active_counts.reserve(session, plan.active_counts)};
    job.scratch = {scratch.reserve(session, plan.scratch)};
    return job;
}

void BatchBuilder::State::upload(std::span<const MeshView> meshes, const Placement& placement,
                                 const BatchJob& job) const {
    const cl::CommandQueue& queue = context.session().queue();
    const cl_map_flags discard = CL_MAP_WRITE_INVALIDATE_REGION;
    const Mapped to_vertices(queue, job.mesh.vertices.buffer, discard, placement.vertices * sizeof(Vec3));
    const Mapped to_triangles(queue, job.mesh.indices.buffer, discard, placement.triangles * sizeof(Triangle));
    in_own_group([&] {
        tbb::parallel_for(std::size_t{0}, meshes.size(), [&](std::size_t i) {
            const BatchRange& range = placement.ranges[i];
            copy_vertices(meshes[i], to_vertices.as<Vec3>() + range.first_vertex);
            copy_triangles(meshes[i], to_triangles.as<Triangle>() + range.first_primitive);
        });
    });
    queue.enqueueWriteBuffer(job.ranges.buffer, CL_TRUE, 0, placement.ranges.size() * sizeof(BatchRange),
                             placement.ranges.data());
}

void BatchBuilder::State::download(const Placement& placement, const BatchPlan& plan, const BatchJob& job,
                                   std::vector<Bvh>& trees) const {
    const cl::CommandQueue& queue = context.session().queue();
    const Mapped from_nodes(queue, job.nodes.buffer, CL_MAP_READ, plan.nodes);
    const Mapped from_ids(queue, job.primitive_ids.buffer, CL_MAP_READ, plan.primitive_ids);
    const Mapped counts(queue, job.active_counts.buffer, CL_MAP_READ, plan.active_counts);
    in_own_group([&] {
        tbb::parallel_for(std::size_t{0}, trees.size(), [&](std::size_t i) {
            const std::size_t first = placement.ranges[i].first_primitive;
            const std::size_t count = counts.as<std::uint32_t>()[i];
            const Node* const tree_nodes = from_nodes.as<Node>() + 2 * first;
            const std::uint32_t* const ids = from_ids.as<std::uint32_t>() + first;
            trees[i].nodes.assign(tree_nodes, tree_nodes + 2 * count);
            trees[i].primitive_ids.assign(ids, ids + count);
        });
    });
}

std::vector<Bvh> BatchBuilder::State::build(std::span<const MeshView> meshes, BuildStats* stats) {
    const Placement placement = place_meshes(meshes);
    const BatchPlan plan = device::plan_batch(placement.triangles, meshes.size());
    check_size(placement.triangles, meshes.size());
    std::vector<Bvh> trees(meshes.size());
    clear(trees, meshes);
    BuildStats result;
    if (placement.triangles > 0) {
        device::with_opencl_errors("a batch of " + std::to_string(meshes.size()) + " trees", [&] {
            const BatchJob job = reserve(placement, plan);
            upload(meshes, placement, job);
            context.session().queue().finish();  // what was unmapped, now and after the batch before
            device::Launcher launcher(context.session(), options.progress);
            launcher.begin_stage("batch", 0.0);
            device::launch_batch(launcher, settings, plan, job);
            result = launcher.finish();
            download(placement, plan, job, trees);
        });
        result.peak_device_bytes = plan.nodes + plan.primitive_ids + plan.active_counts + plan.scratch;
    }
    if (stats != nullptr) *stats = result;
    return trees;
}

BatchBuilder::BatchBuilder(const BuildOptions& options) {
    check_options(options);
    state_ = std::make_unique<State>(Context::open(), options);
}
BatchBuilder::BatchBuilder(Context context, const BuildOptions& options)
    : state_(std::make_unique<State>(std::move(context), options)) {}
BatchBuilder::BatchBuilder(BatchBuilder&&) noexcept = default;
BatchBuilder& BatchBuilder::operator=(BatchBuilder&&) noexcept = default;
BatchBuilder::~BatchBuilder() = default;

std::vector<Bvh> BatchBuilder::build(std::span<const MeshView> meshes, BuildStats* stats) {
    return with_memory_errors("the trees of a batch", [&] { return state_->build(meshes, stats); });
}

DeviceBuildSizes BatchBuilder::sizes(std::uint64_t primitive_count, std::uint64_t tree_count) const {
    state_->check_size(primitive_count, tree_count);
    const BatchPlan plan = device::plan_batch(primitive_count, tree_count);
    return {plan.nodes, plan.primitive_ids, plan.scratch};
}

std::uint64_t BatchBuilder::alignment() const noexcept {
    return state_->alignment;
}

void BatchBuilder::enqueue(cl_command_queue queue, const DeviceInput& input, const DeviceBatch& batch,
                           const DeviceSpan& scratch, const DeviceResult& result, EventList wait_list,
                           cl_event* event) {
    const State& state = *state_;
    Session& session = state.context.session();
    device::enqueue_for_caller(
        "enqueuing a batch", session, {queue, wait_list, event}, [&](device::Launcher& launcher) {
            if (device::count_of(input) == 0 && batch.tree_count > 0) {
                const CallerMemory counts = device::examine(session, "the active count", result.active_count,
                                                            batch.tree_count * std::uint64_t{sizeof(cl_uint)});
                device::check_multiple("the active count's offset", result.active_count.offset, 0, sizeof(cl_uint));
                launcher.clear_uints(counts.given.buffer, counts.given.offset, batch.tree_count);
            } else if (batch.tree_count > 0) {
                const BatchJob job = state.check(input, batch, scratch, result);
                launcher.begin_stage("batch", 0.0);
                device::launch_batch(launcher, state.settings,
                                     device::plan_batch(job.mesh.primitive_count, job.tree_count), job);
            }
        });
}

const BuildOptions& BatchBuilder::options() const noexcept {
    return state_->options;
}
const Context& BatchBuilder::context() const noexcept {
    return state_->context;
}

}  // namespace clbvh
