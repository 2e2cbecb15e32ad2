#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "optimize/edit_tree.hpp"

namespace clbvh::optimizer {

/// Chooses the nodes that are worth a search for a better place.
class Candidates {
public:
    /// About `part`, 0 to 1, of the nodes that may move, at least one, in the order of their slots: those whose parents
    /// are larger than they are by most. That difference bounds what a move saves before ancestors shrink. The same on
    /// any number of threads; valid until the next call.
    [[nodiscard]] std::span<const std::uint32_t> choose(const EditTree& tree, double part);

private:
    void rate(const EditTree& tree);
    struct Threshold {
        std::uint32_t rank;   ///< Those above it are chosen,
        std::uint64_t count;  ///< and of so many at it
        std::uint64_t quota;  ///< so many.
    };

    [[nodiscard]] Threshold find_threshold(double part) const;
    void collect(const Threshold& threshold);

    std::vector<std::uint32_t> ranks_;   // of all slots: leading bits of the difference and 1; 0: may not move
    std::vector<std::uint32_t> counts_;  // of ranks
    std::vector<std::uint32_t> chosen_;
};

}  // namespace clbvh::optimizer
