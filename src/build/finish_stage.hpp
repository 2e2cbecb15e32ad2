#pragma once

#include <cstdint>
#include <span>

#include "build/backend.hpp"
#include "clbvh/core/build_stats.hpp"
#include "clbvh/core/bvh.hpp"
#include "clbvh/options.hpp"
#include "core/scratch.hpp"
#include "host/build/host_stages.hpp"

namespace clbvh {

/// True where the host has optimisers to run.
[[nodiscard]] inline bool optimizes_on_host(const BuildOptions& options) noexcept {
    return !options.optimizers.empty() && options.optimize_on == OptimizeOn::host;
}

/// The stage behind any builder: leaves name the triangles that parts come from, optimisers improve the tree, and
/// leaves are merged where that pays.
class FinishStage {
public:
    explicit FinishStage(const BuildOptions& options) : options_(options) {}

    /// The primitives that the tree in the backend was built over.
    struct Input {
        std::uint64_t primitive_count;           ///< Of the mesh that the caller gave.
        std::span<const std::uint32_t> sources;  ///< The primitive that each part is a part of.
        bool is_presplit;                        ///< False: there are no parts, and ids stay.
    };

    /// Finishes the tree of the backend's last run, as the build's part from fraction `begin` to 1, and books it. Keeps
    /// its memory.
    void run(Backend& backend, const Input& input, double begin, BuildStats& stats);

    /// The tree of the last run.
    [[nodiscard]] const Bvh& tree() const noexcept { return result_; }

private:
    void optimize(Bvh& tree, host::HostStages& stages, double begin) const;

    const BuildOptions& options_;
    Scratch scratch_;
    Bvh result_;
};

}  // namespace clbvh
