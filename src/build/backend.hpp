#pragma once

#include <tbb/task_arena.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "catalog/builder_rows.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/device/context.hpp"
#include "clbvh/options.hpp"
#include "layout/wide_converter.hpp"

namespace clbvh {

/// Where a builder runs, the host or an OpenCL device, behind one face. Builder keeps the order of the calls.
class Backend {
public:
    virtual ~Backend() = default;

    /// The primitives that run() builds over.
    struct Input {
        Primitives primitives;           ///< Passed by check_primitives. They stay as they are until the next upload.
        std::uint64_t active_count = 0;  ///< Those of them that are active.
        std::optional<MeshView> cut;     ///< Boxes: the triangle that each one holds a part of, where that is known.
    };

    /// Makes the input available where the builder runs.
    virtual void upload(const Input& input) = 0;
    /// Builds over what was uploaded, and keeps the tree.
    virtual BuildStats run() = 0;
    /// Lets go of what was uploaded; the tree stays.
    virtual void release_input() = 0;
    /// Calls `read` with the tree of the last run: where it lies, if the host can read it there.
    virtual void with_tree(const std::function<void(const layout::TreeView&)>& read) = 0;
    /// A copy of the tree of the last run.
    [[nodiscard]] virtual Bvh download() const = 0;
    /// The tree of the last run on the host, without holes, for the caller to work on: it is then no longer to be
    /// downloaded. Valid until the next call.
    [[nodiscard]] virtual Bvh& tree() = 0;
    /// True where tree() has to fetch it.
    [[nodiscard]] virtual bool is_remote() const noexcept = 0;
    /// The shape that DeviceConfig::shape was resolved to; automatic where there are no kernels.
    [[nodiscard]] virtual Shape shape() const noexcept = 0;
};

/// `options` are in range; they and the arena, where all work is done, outlive the backend.
[[nodiscard]] std::unique_ptr<Backend> make_host_backend(const BuilderRow& row, const BuildOptions& options,
                                                         tbb::task_arena& arena);
/// Likewise, but the arena is for the host's part. Throws where the device cannot do what `options` ask for.
[[nodiscard]] std::unique_ptr<Backend> make_device_backend(const BuilderRow& row, const BuildOptions& options,
                                                           const Context& context, tbb::task_arena& arena);

}  // namespace clbvh
