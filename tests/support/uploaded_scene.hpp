#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/device/device_tracer.hpp"
#include "device/opencl/session.hpp"
#include "support/builders.hpp"

namespace clbvh::test {

/// A buffer of the shared context that holds `values`; never of no size.
template <typename T>
[[nodiscard]] cl::Buffer upload(const std::vector<T>& values) {
    const device::Session& session = shared_context().session();
    const std::size_t bytes = values.size() * sizeof(T);
    const cl::Buffer buffer(session.context(), CL_MEM_READ_WRITE, std::max<std::size_t>(bytes, 64));
    if (bytes > 0) session.queue().enqueueWriteBuffer(buffer, CL_TRUE, 0, bytes, values.data());
    return buffer;
}

/// A tree and a mesh of the host's in device memory.
struct UploadedScene {
    cl::Buffer nodes, ids, vertices, indices;
    DeviceScene scene;

    UploadedScene(const Bvh& bvh, const Mesh& mesh)
        : nodes(upload(bvh.nodes)),
          ids(upload(bvh.primitive_ids)),
          vertices(upload(mesh.vertices)),
          indices(upload(mesh.triangles)) {
        scene.bvh = {{nodes()},
                     static_cast<std::uint32_t>(bvh.nodes.size()),
                     {ids()},
                     static_cast<std::uint32_t>(bvh.primitive_ids.size())};
        scene.triangles.count = static_cast<std::uint32_t>(mesh.triangles.size());
        scene.triangles.vertices = {vertices()};
        scene.triangles.indices = {indices()};
    }
};

}  // namespace clbvh::test
