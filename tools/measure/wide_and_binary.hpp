#pragma once

#include <clbvh/core/ray.hpp>
#include <cstddef>
#include <list>
#include <string>
#include <vector>

#include "measure/counting_engine.hpp"
#include "measure/ray_cost.hpp"

namespace clbvh::tool {

class RoundsProgress;

/// Cost of rays with trees, both ways: as engines go where nothing is counted, eight children at a time, and through
/// the trees' own nodes (CountingEngine). All take their turns in the same rounds.
class WideAndBinary {
public:
    /// `engine` outlives this object.
    void add(const std::string& name, RayEngine& engine);

    /// As measure_rays().
    void measure(RayEngine& reference, const RaySet& set, std::size_t runs, RoundsProgress& progress);

    /// Of the i-th engine that was added, once they were measured.
    [[nodiscard]] const RayCost& cost(std::size_t i) const { return costs_[2 * i]; }
    [[nodiscard]] const RayCost& binary_cost(std::size_t i) const { return costs_[2 * i + 1]; }

private:
    std::vector<RayCounts> counts_;
    std::list<CountingEngine> counting_;  // entrants point into it
    std::vector<RayEntrant> entrants_;
    std::vector<RayCost> costs_;
};

}  // namespace clbvh::tool
