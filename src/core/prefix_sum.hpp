#pragma once

#include <span>
#include <utility>

namespace clbvh {

/// Turns counts into the sum of those before each one; returns the sum of all.
template <typename Count>
Count sum_before(std::span<Count> counts) {
    Count before = 0;
    for (Count& count : counts)
        before += std::exchange(count, before);
    return before;
}

}  // namespace clbvh
