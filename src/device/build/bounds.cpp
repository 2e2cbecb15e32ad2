#include "device/build/bounds.hpp"

#include "clbvh/core/mesh.hpp"

namespace clbvh::device {
namespace {

std::string_view kernel_of(InputForm form) {
    switch (form) {
        case InputForm::indexed_32: return "indexed_32_bounds";
        case InputForm::indexed_16: return "indexed_16_bounds";
        case InputForm::triangles: return "triangle_bounds";
        case InputForm::boxes: return "box_bounds";
        default: return "primitive_bounds";
    }
}

/// Bytes to read of the input. How many vertices there are is known of the tight form alone, which fills its buffer;
/// elsewhere three a primitive are an upper bound.
std::uint64_t input_bytes(const DeviceMesh& mesh) {
    const std::uint64_t n = mesh.primitive_count;
    switch (mesh.form) {
        case InputForm::tight: return mesh.vertices.buffer.getInfo<CL_MEM_SIZE>() + sizeof(Triangle) * n;
        case InputForm::boxes: return sizeof(Aabb) * n;
        default: return (sizeof(Triangle) + 3 * sizeof(Vec3)) * n;
    }
}

}  // namespace

ProgramSpec bounds_program(const DeviceFit& fit) {
    return {"bounds.cl", fit.stream_group_size, ""};
}

void launch_bounds(Launcher& launcher, const DeviceFit& fit, const BuildBuffers& buffers, const DeviceMesh& mesh) {
    Session& session = launcher.session();
    Kernel& primitives = session.kernel(bounds_program(fit), kernel_of(mesh.form));
    Kernel& reduce = session.kernel(bounds_program(fit), "reduce_bounds");
    const Pieces pieces = fit.stream_pieces(mesh.primitive_count);
    launcher.launch(primitives, pieces.count, mesh.vertices.buffer, mesh.vertices.offset, mesh.vertex_stride,
                    mesh.index_buffer(), mesh.indices.offset, mesh.index_stride, mesh.primitive_count, pieces.length,
                    buffers.boxes, buffers.partial_bounds, buffers.partial_counts);
    launcher.count_bytes(input_bytes(mesh) + sizeof(Aabb) * std::uint64_t{mesh.primitive_count});
    launcher.launch(reduce, 1, buffers.partial_bounds, buffers.partial_counts, pieces.count, buffers.bounds,
                    buffers.primitive_count);
}

}  // namespace clbvh::device
