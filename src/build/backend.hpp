#pragma once

#include <tbb/task_arena.h>

#include <cstdint>
#include <memory>

#include "catalog/builder_rows.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/options.hpp"

namespace clbvh {

/// Where a builder runs, the host or an OpenCL device, behind one face. Builder keeps the order of the calls.
class Backend {
public:
    virtual ~Backend() = default;

    /// Takes a copy of a mesh that check_mesh has passed, with `active_count` active triangles.
    virtual void upload(const Mesh& mesh, std::uint64_t active_count) = 0;
    /// The same for parts of triangles, all of them active: `boxes` has a triangle for each that stands for its box,
    /// and `triangles` the whole triangle that it is a part of. Both may be referred to until the next upload.
    virtual void upload_parts(const Mesh& boxes, const Mesh& triangles) = 0;
    /// Builds from the uploaded mesh, and keeps the tree.
    virtual BuildStats run() = 0;
    /// A copy of the tree of the last run.
    [[nodiscard]] virtual Bvh download() const = 0;
    /// The tree of the last run on the host, without holes, for the caller to work on: it is then no longer to be
    /// downloaded. Valid until the next call.
    [[nodiscard]] virtual Bvh& tree() = 0;
    /// True where tree() has to fetch it.
    [[nodiscard]] virtual bool is_remote() const noexcept = 0;
    /// What DeviceConfig::shape was resolved to; automatic where there are no kernels.
    [[nodiscard]] virtual Shape shape() const noexcept = 0;
};

/// `options` are in range; they and the arena, where all work is done, outlive the backend.
[[nodiscard]] std::unique_ptr<Backend> make_host_backend(const BuilderRow& row, const BuildOptions& options,
                                                         tbb::task_arena& arena);
/// Throws where the device cannot do what `options` ask for.
[[nodiscard]] std::unique_ptr<Backend> make_device_backend(const BuilderRow& row, const BuildOptions& options,
                                                           const Context& context);

}  // namespace clbvh
