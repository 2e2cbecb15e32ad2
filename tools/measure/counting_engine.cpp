#include "measure/counting_engine.hpp"

namespace clbvh::tool {

void CountingEngine::closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) {
    engine_.closest(rays, hits, place_for(rays.size(), counts));
}

void CountingEngine::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) {
    engine_.any(rays, is_hit, place_for(rays.size(), counts));
}

std::span<RayCounts> CountingEngine::place_for(std::size_t size, std::span<RayCounts> counts) {
    if (!counts.empty()) return counts;
    counts_.resize(size);
    return counts_;
}

}  // namespace clbvh::tool
