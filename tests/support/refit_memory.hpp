#pragma once

#include <vector>

#include "clbvh/core/mesh.hpp"
#include "clbvh/device/device_refitter.hpp"
#include "device/opencl/opencl.hpp"

namespace clbvh::test {

/// A buffer of the shared context, of at least `bytes`, filled with a byte that is no box.
[[nodiscard]] cl::Buffer filled_buffer(std::uint64_t bytes);

/// A refitter on the shared context.
[[nodiscard]] DeviceRefitter make_refitter(Shape shape, const SahCosts& costs = {});

/// Checks two costs that a refitter wrote.
void expect_costs(const std::vector<float>& sah, double before, double after);

/// A tree of the host's and its mesh in device memory, with what refitting it takes.
class RefitMemory {
public:
    RefitMemory(const DeviceRefitter& refitter, const Bvh& tree, const Mesh& mesh);

    [[nodiscard]] DeviceBvh tree() const {
        return {{nodes_()},
                static_cast<std::uint32_t>(tree_.nodes.size()),
                {ids_()},
                static_cast<std::uint32_t>(tree_.primitive_ids.size()),
                {}};
    }
    [[nodiscard]] DeviceSpan order() const { return {order_()}; }
    [[nodiscard]] DeviceSpan scratch() const { return {scratch_()}; }
    [[nodiscard]] DeviceSpan sah() const { return {sah_(), 4}; }
    [[nodiscard]] DeviceRefit refit() const { return {triangles_, order(), scratch(), sah()}; }

    [[nodiscard]] Bvh read_tree() const;
    /// Cost before and after, or the cost and what was there.
    [[nodiscard]] std::vector<float> read_sah() const;
    void move(const Mesh& moved) const;

private:
    Bvh tree_;
    DeviceRefitSizes sizes_;
    cl::Buffer nodes_, ids_, vertices_, indices_, order_, scratch_, sah_;
    DeviceTriangles triangles_;
};

}  // namespace clbvh::test
