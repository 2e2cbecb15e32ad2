#pragma once

namespace clbvh {

/// Says when a tree that is refitted from frame to frame is better built anew. Refits keep a tree's structure, and rays
/// through it cost more the further the mesh moves from where it was built. A build pays once that loss, summed over
/// the frames since the last build, has reached what a build costs: as long as an older tree is no better
/// than a newer one, build and loss together are
/// then at most twice, and one frame's loss more, what the best moments would have cost (the ski rental problem).
///
///     clbvh::RebuildPolicy policy(build_ms, trace_ms);      // measured at a fresh tree
///     for (;;) {
///         const double rise = refitter.refit(tree, mesh).sah_after / sah_of_fresh_tree;
///         if (policy.should_rebuild(rise)) { tree = builder.build(mesh); policy.rebuilt(build_ms, trace_ms); }
///         trace(tree);
///     }
class RebuildPolicy {
public:
    /// `build_ms`: of a build, layouts and uploads included, less that of a refit. `trace_ms`: of a frame's rays
    /// through a fresh tree. Both in milliseconds; what is negative or not a number counts as 0.
    RebuildPolicy(double build_ms, double trace_ms) noexcept { rebuilt(build_ms, trace_ms); }

    /// Call it once a frame. `rise` is the SAH cost of the refitted tree over that of the fresh one, or any other
    /// measure of what rays cost there, such as measured times; below 1 it counts as 1. True where the loss so far,
    /// this frame's included, is what a build costs; the answer stays true until rebuilt().
    [[nodiscard]] bool should_rebuild(double rise) noexcept {
        if (rise > 1.0) loss_ms_ += trace_ms_ * (rise - 1.0);
        return loss_ms_ > 0.0 && loss_ms_ >= build_ms_;
    }

    /// Begins anew with a fresh tree, and what was measured with it.
    void rebuilt(double build_ms, double trace_ms) noexcept {
        build_ms_ = build_ms > 0.0 ? build_ms : 0.0;
        trace_ms_ = trace_ms > 0.0 ? trace_ms : 0.0;
        loss_ms_ = 0.0;
    }

    /// What rays have cost more than through a fresh tree, in milliseconds, since the last build.
    [[nodiscard]] double loss_ms() const noexcept { return loss_ms_; }

private:
    double build_ms_ = 0.0;
    double trace_ms_ = 0.0;
    double loss_ms_ = 0.0;
};

}  // namespace clbvh
