#include "device/stage_bench.hpp"

#include <cstring>

#include "support/builders.hpp"

namespace clbvh::test {
namespace {

const cl::CommandQueue& queue() {
    return shared_context().session().queue();
}

cl::Buffer upload(const void* data, std::size_t bytes) {
    const cl::Buffer buffer(shared_context().session().context(), CL_MEM_READ_ONLY, bytes);
    write_bytes(buffer, data, bytes);
    return buffer;
}

}  // namespace

StageBench::StageBench(const BuildOptions& options, std::size_t primitives, const device::DeviceAlgorithm* algorithm)
    : session(shared_context().session()),
      settings(device::resolve_settings(options, session)),
      progress(options.progress),
      launcher(session, progress) {
    const auto count = static_cast<std::uint32_t>(primitives);
    buffers.reserve(session, settings, count, algorithm != nullptr ? algorithm->extra_bytes(settings, count) : 0);
    launcher.begin_stage("test", 0.0);
}

device::DeviceMesh upload_mesh(const Mesh& mesh) {
    device::DeviceMesh uploaded;
    uploaded.vertices = upload(mesh.vertices.data(), mesh.vertices.size() * sizeof(Vec3));
    uploaded.triangles = upload(mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
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
