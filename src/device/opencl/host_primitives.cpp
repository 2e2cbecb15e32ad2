#include "device/opencl/host_primitives.hpp"

namespace clbvh::device {
namespace {

/// Memory of the caller's, without what is behind its last element.
struct HostArray {
    const void* first;
    std::uint64_t count;
    std::uint64_t stride;
    std::uint64_t element;

    [[nodiscard]] std::uint64_t bytes() const noexcept { return count > 0 ? (count - 1) * stride + element : 0; }
};

/// An empty array becomes a null buffer, which no kernel is given.
cl::Buffer bind(Session& session, const HostArray& array) {
    if (array.count == 0) return {};
    // No kernel writes to it, and OpenCL has no pointer to constants.
    void* const memory = const_cast<void*>(array.first);
    if (session.info().type == DeviceType::cpu)
        return {session.context(), CL_MEM_READ_ONLY | CL_MEM_USE_HOST_PTR, array.bytes(), memory};
    cl::Buffer buffer(session.context(), CL_MEM_READ_ONLY, array.bytes());
    session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, array.bytes(), memory);
    return buffer;
}

DeviceMesh bind(Session& session, const BoxView& boxes) {
    DeviceMesh result;
    result.form = InputForm::boxes;
    result.vertices = {bind(session, {boxes.boxes, boxes.count, boxes.stride, sizeof(Aabb)})};
    result.vertex_stride = boxes.stride;
    return result;
}

InputForm form_of(const MeshView& mesh) {
    if (mesh.indices == nullptr) return InputForm::triangles;
    if (mesh.index_type == IndexType::uint16) return InputForm::indexed_16;
    const bool is_tight = mesh.vertex_stride == sizeof(Vec3) && mesh.bytes_between_triangles() == sizeof(Triangle);
    return is_tight ? InputForm::tight : InputForm::indexed_32;
}

DeviceMesh bind(Session& session, const MeshView& mesh) {
    DeviceMesh result;
    result.form = form_of(mesh);
    result.vertices = {bind(session, {mesh.vertices, mesh.vertex_count, mesh.vertex_stride, sizeof(Vec3)})};
    result.vertex_stride = mesh.vertex_stride;
    if (mesh.indices == nullptr) return result;
    const std::uint64_t index_bytes =
        mesh.index_type == IndexType::uint16 ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
    result.index_stride = mesh.bytes_between_triangles();
    result.indices = {bind(session, {mesh.indices, mesh.triangle_count, result.index_stride, 3 * index_bytes})};
    return result;
}

}  // namespace

DeviceMesh bind_primitives(Session& session, const Primitives& primitives, std::uint64_t active_count) {
    DeviceMesh result = std::visit([&](const auto& view) { return bind(session, view); }, primitives);
    result.primitive_count = static_cast<std::uint32_t>(count_of(primitives));
    result.active_count = static_cast<std::uint32_t>(active_count);
    return result;
}

}  // namespace clbvh::device
