#include "host/top_down/binned_move.hpp"

#include "host/top_down/binning_loops.hpp"

namespace clbvh::host {

std::uint32_t move_references(std::span<const Reference> range, const Binning& binning, const BinnedSplit& split,
                              Reference* left, Reference* right, Sides& sides) noexcept {
    return binning_loops().move(range, binning, split, left, right, sides);
}

}  // namespace clbvh::host
