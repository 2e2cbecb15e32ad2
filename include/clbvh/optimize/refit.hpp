#pragma once

#include <memory>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/mesh.hpp"
#include "clbvh/export.h"
#include "clbvh/metrics/sah.hpp"

namespace clbvh {

/// The SAH cost of a tree before and after a refit.
struct RefitStats {
    double sah_before = 0.0;  ///< As sah_cost(), up to rounding: with the boxes that were there.
    double sah_after = 0.0;   ///< With the new ones.

    /// By what factor the cost rose. Of a fresh build's cost it says when to build anew: see docs/optimize.md.
    [[nodiscard]] double rise() const noexcept { return sah_before > 0.0 ? sah_after / sah_before : 1.0; }
};

/// Gives the tree the boxes that its primitives, triangles or boxes, now ask for; its structure stays. O(n) time, in
/// the calling task arena of oneTBB. For one call: Refitter is faster from the second one on.
///
/// `primitives` are those that the tree was built over, at new places. Where references were split, leaves get the
/// boxes of whole primitives. Throws Error(invalid_input) where there is another number of them, where check_primitives
/// refuses them, where a cost is negative or not finite, or where another primitive than before is inactive, naming it;
/// Error(unsupported) where `nodes` has more than 2^31 - 2 slots; and Error(out_of_memory). After invalid_input the
/// tree is as it was (save for a Refitter given another tree, see there). Where memory runs out, some boxes are old and
/// some new: the next refit that succeeds puts all of them right.
CLBVH_API RefitStats refit(Bvh& tree, const Primitives& primitives, const SahCosts& costs = {});

/// Refits trees of one structure again and again, every frame say: the order in which their nodes are visited is found
/// once. It keeps 4 bytes for each inner node, and no reference to the tree. One thread at a time.
class CLBVH_API Refitter {
public:
    /// Takes every tree that validate() accepts. O(n) time, in the calling task arena of oneTBB, about that of a call
    /// of refit(). Throws Error(unsupported) as refit() does, and Error(out_of_memory).
    explicit Refitter(const Bvh& tree);
    Refitter(const Refitter&) = delete;
    Refitter(Refitter&&) noexcept;
    Refitter& operator=(const Refitter&) = delete;
    Refitter& operator=(Refitter&&) noexcept;
    ~Refitter();

    /// As clbvh::refit(), with the same boxes to the bit, the same errors, and the same statistics on any number of
    /// threads.
    ///
    /// `tree` is the one that the refitter was made for, or a copy, whatever its boxes and its leaves' primitives are.
    /// Throws Error(invalid_input) for one with another number of nodes, the tree being as it was. A tree of as many
    /// nodes whose inner nodes have other children, or are others, is found out as well, but while boxes are written:
    /// Error(invalid_input), and some of its boxes are no longer right until refit() has gone over it.
    RefitStats refit(Bvh& tree, const Primitives& primitives, const SahCosts& costs = {});

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clbvh
