#include "device/bounds.hpp"

#include "clbvh/core/mesh.hpp"

namespace clbvh::device {

void launch_bounds(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   const DeviceMesh& mesh) {
    Session& session = launcher.session();
    Kernel& primitives = session.kernel("bounds.cl", "primitive_bounds", settings.stream_group_size, "");
    Kernel& reduce = session.kernel("bounds.cl", "reduce_bounds", settings.stream_group_size, "");
    const Pieces pieces = settings.stream_pieces(mesh.primitive_count);
    launcher.launch(primitives, pieces.count, mesh.vertices, mesh.triangles, mesh.primitive_count, pieces.length,
                    buffers.boxes, buffers.partial_bounds, buffers.partial_counts);
    launcher.count_bytes(mesh.vertices.getInfo<CL_MEM_SIZE>() +
                         (sizeof(Triangle) + sizeof(Aabb)) * std::uint64_t{mesh.primitive_count});
    launcher.launch(reduce, 1, buffers.partial_bounds, buffers.partial_counts, pieces.count, buffers.bounds,
                    buffers.leaf_count);
}

}  // namespace clbvh::device
