#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "clbvh/catalog.hpp"
#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"
#include "clbvh/layout/wide.hpp"
#include "clbvh/options.hpp"
#include "clbvh/trace/tracer.hpp"

namespace clbvh {

class Context;

/// Builds trees with one builder, on the host or on one device, and keeps programs and memory between builds.
///
///     clbvh::Builder builder("plocpp");
///     clbvh::Bvh bvh = builder.build(mesh);
///
/// build() is upload(), run() and download() in one call; the three apart let a caller time or repeat the middle. A
/// Mesh, a MeshView, a BoxView and a vector or span of Aabb may be given wherever it says Primitives.
/// After any exception the builder can be used again. One thread at a time.
class CLBVH_API Builder {
public:
    /// Of a builder, or of a preset. Opens the default device where the builder needs one. Throws what Context::open,
    /// find_builder and check_options throw.
    explicit Builder(std::string_view builder_id, const BuildOptions& options = {});
    /// Runs on the caller's device; a host builder leaves it alone.
    Builder(std::string_view builder_id, Context context, const BuildOptions& options = {});
    Builder(const Builder&) = delete;
    Builder(Builder&&) noexcept;
    Builder& operator=(const Builder&) = delete;
    Builder& operator=(Builder&&) noexcept;
    ~Builder();

    /// Uploads, runs, downloads, and lets go of the primitives. Fills `stats` where given.
    [[nodiscard]] Bvh build(const Primitives& primitives, BuildStats* stats = nullptr);

    /// Builds a tree over triangles straight to what rays are traced through: the same as make_layout makes of
    /// build()'s tree, but the tree is neither copied nor checked again, and all memory stays for the next build, that
    /// of `result` as well. BuildStats gets a stage "wide8" more. Throws what build() and make_layout throw; `result`
    /// is then empty.
    void build_layout(const MeshView& mesh, Wide8& result, BuildStats* stats = nullptr);
    /// The same, to a tracer that owns its layout: the mesh may go.
    [[nodiscard]] Tracer build_tracer(const MeshView& mesh, const TracerOptions& options = {},
                                      BuildStats* stats = nullptr);

    /// Checks triangles or boxes (throws what check_primitives throws, before any work) and makes them available where
    /// the builder runs. Host builders and builders on CPU devices read the caller's arrays, without a copy: these must
    /// stay as they are until the last run() over them has returned. Other devices get a copy. With
    /// BuildOptions::presplit_level or split_quota triangles are split first, which may be cancelled as run() may; the
    /// time counts in the statistics of each run() over them; boxes are then refused with Error(unsupported).
    void upload(const Primitives& primitives);
    /// The same, but the builder keeps the mesh, which may be a temporary, until the next upload.
    void upload(Mesh&& mesh);
    /// The same for boxes.
    void upload(std::vector<Aabb>&& boxes);
    /// Builds over the uploaded primitives to a finished tree in the builder's own memory, and waits for it; as often
    /// as wanted. With BuildOptions::max_leaf_size, presplit_level or split_quota, the host finishes the tree: leaves
    /// name the uploaded primitives, each once a leaf, and are merged where that lowers the SAH cost. Throws
    /// Error(invalid_input) where nothing was uploaded (build() leaves nothing), Error(cancelled) where the progress
    /// callback said no.
    BuildStats run();
    /// A copy of the last finished tree. Throws Error(invalid_input) where there is none.
    [[nodiscard]] Bvh download() const;

    /// The id that the builder was made with: of a builder or of a preset.
    [[nodiscard]] std::string_view id() const noexcept;
    [[nodiscard]] const BuilderInfo& info() const noexcept;
    /// As they were given, save for what a preset put in the place of defaults, and treelet-split for split_quota.
    [[nodiscard]] const BuildOptions& options() const noexcept;
    /// Throws Error(unsupported) for a host builder.
    [[nodiscard]] const Context& context() const;
    /// The shape that runs: what DeviceConfig::shape was resolved to, group or lane; automatic for a host builder.
    [[nodiscard]] Shape shape() const noexcept;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// One call from triangles or boxes of the host to a tree, on the default device.
[[nodiscard]] CLBVH_API Bvh build(const Primitives& primitives, std::string_view builder_id = "plocpp",
                                  const BuildOptions& options = {}, BuildStats* stats = nullptr);

/// One call from triangles of the host to rays.
///
///     const clbvh::Tracer tracer = clbvh::build_tracer(mesh, "balanced");
///     const clbvh::Hit hit = tracer.closest(ray);
[[nodiscard]] CLBVH_API Tracer build_tracer(const MeshView& mesh, std::string_view builder_id = "plocpp",
                                            const BuildOptions& options = {}, const TracerOptions& tracing = {},
                                            BuildStats* stats = nullptr);

}  // namespace clbvh
