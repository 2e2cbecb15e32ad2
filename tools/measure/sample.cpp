#include "measure/sample.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace clbvh::tool {

Sample summarize(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    const double median = values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
    return {median, values.front(), values.back()};
}

double geometric_mean(std::span<const double> values) {
    double log_sum = 0.0;
    for (const double value : values)
        log_sum += std::log(value);
    return std::exp(log_sum / static_cast<double>(values.size()));
}

}  // namespace clbvh::tool
