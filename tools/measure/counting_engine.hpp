#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "measure/ray_engine.hpp"

namespace clbvh::tool {

/// An engine that always counts, and so visits the tree's own nodes, two children at a time. Where nothing is counted,
/// engines go through eight at a time instead, but for a device in the group shape.
class CountingEngine final : public RayEngine {
public:
    /// `engine` outlives this object, and so do `counts`, which are overwritten; engines that take turns may share
    /// them.
    CountingEngine(RayEngine& engine, std::vector<RayCounts>& counts) : engine_(engine), counts_(counts) {}

    [[nodiscard]] std::size_t rays_at_once() const override { return engine_.rays_at_once(); }
    void closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) override;
    void any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) override;
    void visits(std::span<const Ray> rays, std::span<RayCounts> counts) override { engine_.visits(rays, counts); }

private:
    /// `counts`, or where there are none a place for `size` of them.
    [[nodiscard]] std::span<RayCounts> place_for(std::size_t size, std::span<RayCounts> counts);

    RayEngine& engine_;
    std::vector<RayCounts>& counts_;
};

}  // namespace clbvh::tool
