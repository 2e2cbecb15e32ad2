#pragma once

#include <span>
#include <vector>

namespace clbvh::tool {

/// Statistics of repeated measurements.
struct Sample {
    double median = 0.0;
    double min = 0.0;
    double max = 0.0;
};

/// The median is the mean of the middle two where their number is even. All zero where there are no values.
[[nodiscard]] Sample summarize(std::vector<double> values);

/// NaN where there are no values.
[[nodiscard]] double geometric_mean(std::span<const double> values);

}  // namespace clbvh::tool
