#pragma once

#include <cstdint>
#include <vector>

#include "clbvh/core/primitives.hpp"
#include "clbvh/host/presplit.hpp"
#include "host/build/host_stages.hpp"

namespace clbvh::host {

/// The parts of a mesh's active triangles, as boxes that builders of either kind can be given.
struct PartBoxes {
    std::vector<Aabb> boxes;
    std::vector<std::uint32_t> source;  ///< The triangle that each part is a part of; ascending.
};

/// Splits a mesh that check_mesh has passed. Each box contains its exact part and lies in the box of the triangle; that
/// of a triangle in one part is the triangle's. `config` is in range, a stage has begun, `parts` may hold older ones.
void presplit(const MeshView& mesh, const PresplitConfig& config, HostStages& stages, PartBoxes& parts);

}  // namespace clbvh::host
