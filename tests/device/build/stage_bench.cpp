#include "device/build/stage_bench.hpp"

#include <algorithm>
#include <cstring>

#include "catalog/builder_rows.hpp"
#include "support/builders.hpp"

namespace clbvh::test {
namespace {

const cl::CommandQueue& queue() {
    return shared_context().session().queue();
}

cl::Buffer upload(const device::Session& session, const void* data, std::size_t bytes) {
    const cl::Buffer buffer(session.context(), CL_MEM_READ_ONLY, bytes);
    session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, bytes, data);
    return buffer;
}

}  // namespace

const device::DeviceAlgorithm& algorithm_of(std::string_view id) {
    return *find_builder_row(id).device_algorithm;
}

device::BuildSettings settings_of(const BuildOptions& options) {
    return device::resolve_settings(algorithm_of("plocpp"), options, shared_context().session());
}

device::BuildSettings large_device_settings(const BuildOptions& options) {
    device::BuildSettings settings = settings_of(options);
    settings.groups_to_fill = device::kMostPieces;
    settings.most_sort_pieces = device::kMostPieces;
    return settings;
}

device::BuildSettings small_group_settings(const BuildOptions& options, std::size_t largest_group) {
    device::BuildSettings settings = settings_of(options);
    settings.stream_group_size = std::min(settings.stream_group_size, largest_group);
    settings.sort_group_size = std::min(settings.sort_group_size, largest_group);
    return settings;
}

StageBench::StageBench(const device::BuildSettings& build_settings, std::size_t primitives,
                       const device::DeviceAlgorithm* algorithm, ProgressCallback progress_callback)
    : session(shared_context().session()),
      settings(build_settings),
      buffers(memory.buffers()),
      progress(std::move(progress_callback)),
      launcher(session, progress) {
    const auto count = static_cast<std::uint32_t>(primitives);
    const device::BoxOrder box_order = algorithm != nullptr ? algorithm->box_order : device::BoxOrder::morton;
    const std::uint64_t extra_bytes = algorithm != nullptr ? algorithm->extra_bytes(settings, count) : 0;
    memory.reserve(session, device::plan_memory(settings, box_order, count, extra_bytes));
    write(buffers.primitive_count, std::vector<std::uint32_t>{count});
    launcher.begin_stage("test", 0.0);
}

StageBench::StageBench(const BuildOptions& options, std::size_t primitives)
    : StageBench(settings_of(options), primitives) {}

device::DeviceMesh upload_mesh(const device::Session& session, const Mesh& mesh) {
    device::DeviceMesh uploaded;
    uploaded.vertices = {upload(session, mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3))};
    uploaded.indices = {upload(session, mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle))};
    uploaded.primitive_count = static_cast<std::uint32_t>(mesh.triangles.size());
    uploaded.active_count = static_cast<std::uint32_t>(mesh.triangles.size() - check_mesh(mesh));
    return uploaded;
}

void write_bytes(const cl::Buffer& buffer, const void* data, std::size_t bytes) {
    if (bytes > 0) queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, bytes, data);
}

void read_bytes(const cl::Buffer& buffer, void* data, std::size_t bytes) {
    if (bytes > 0) queue().enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, data);
}

void fill_bytes(const cl::Buffer& buffer, std::uint8_t value) {
    const std::vector<std::uint8_t> bytes(buffer.getInfo<CL_MEM_SIZE>(), value);
    write(buffer, bytes);
}

bool is_same_bits(const Aabb& a, const Aabb& b) {
    return std::memcmp(&a, &b, sizeof(Aabb)) == 0;
}

}  // namespace clbvh::test
