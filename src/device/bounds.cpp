#include "device/bounds.hpp"

namespace clbvh::device {

void launch_bounds(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   const DeviceMesh& mesh) {
    Session& session = launcher.session();
    Kernel& primitives = session.kernel("bounds.cl", "primitive_bounds", settings.stream_group_size, "");
    Kernel& reduce = session.kernel("bounds.cl", "reduce_bounds", settings.stream_group_size, "");
    const Pieces pieces = settings.stream_pieces(mesh.primitive_count);
    launcher.launch(primitives, pieces.count, mesh.vertices, mesh.triangles, mesh.primitive_count, pieces.length,
                    buffers.boxes, buffers.partial_bounds);
    launcher.launch(reduce, 1, buffers.partial_bounds, pieces.count, buffers.bounds);
}

}  // namespace clbvh::device
