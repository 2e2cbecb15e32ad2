#include "measure/sort_contestant.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>

#include "cli/stopwatch.hpp"

namespace clbvh::tool {

SortContestant::SortContestant(std::size_t count) : sort_(count), random_keys_(count), keys_(count), values_(count) {
    std::mt19937_64 random;
    std::generate(random_keys_.begin(), random_keys_.end(), std::ref(random));
}

void SortContestant::run(bool counted) {
    std::copy(random_keys_.begin(), random_keys_.end(), keys_.begin());
    std::iota(values_.begin(), values_.end(), 0u);
    const Stopwatch stopwatch;
    sort_.sort(keys_, values_);
    if (counted) milliseconds_.push_back(stopwatch.milliseconds());
}

}  // namespace clbvh::tool
