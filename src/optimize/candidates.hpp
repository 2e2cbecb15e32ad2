#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "optimize/edit_tree.hpp"

namespace clbvh::optimizer {

/// Chooses the nodes that are worth a search for a better place: those whose parents are larger than they are by most.
/// That difference bounds what a move saves before ancestors shrink. It rates all nodes once, and then those that moves
/// have touched: early passes search so little that rating would take most of their time.
class Candidates {
public:
    explicit Candidates(const EditTree& tree);

    /// About `part`, 0 to 1, of the nodes that may move, at least one, in the order of their slots. The same on any
    /// number of threads; valid until the next call.
    [[nodiscard]] std::span<const std::uint32_t> choose(double part);

    /// The node in `slot` has changed since the last choice.
    void touch(std::uint32_t slot) { touched_.push_back(slot); }

    /// EditTree::inner_half_area() at the time of the construction.
    [[nodiscard]] double initial_area() const noexcept { return initial_area_; }

private:
    using Rank = std::uint16_t;

    [[nodiscard]] std::pair<Rank, Rank> ranks_of(std::uint32_t pair, float parent_area) const;
    void rate_all();
    void rate_touched();
    void rate_again(std::uint32_t pair, std::vector<std::int32_t>& changes);
    struct Threshold {
        std::uint32_t rank;   ///< Those above it are chosen,
        std::uint64_t count;  ///< and of so many at it
        std::uint64_t quota;  ///< so many.
    };

    [[nodiscard]] Threshold find_threshold(double part) const;
    void collect(const Threshold& threshold);

    const EditTree& tree_;
    double initial_area_ = 0.0;
    std::vector<Rank> ranks_;            // of all slots: leading bits of the difference and 1; 0: may not move
    std::vector<std::uint32_t> counts_;  // of ranks
    std::vector<std::uint32_t> touched_;
    std::vector<std::uint32_t> chosen_;
};

}  // namespace clbvh::optimizer
