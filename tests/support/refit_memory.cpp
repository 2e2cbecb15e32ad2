#include "support/refit_memory.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

namespace clbvh::test {
namespace {

template <typename T>
cl::Buffer uploaded(const std::vector<T>& values) {
    const cl::Buffer buffer = filled_buffer(values.size() * sizeof(T));
    if (!values.empty()) write(buffer, values);
    return buffer;
}

}  // namespace

cl::Buffer filled_buffer(std::uint64_t bytes) {
    cl::Buffer buffer(shared_context().session().context(), CL_MEM_READ_WRITE, bytes + 64);
    fill_bytes(buffer, 0x5a);
    return buffer;
}

DeviceRefitter make_refitter(Shape shape, const SahCosts& costs) {
    DeviceRefitterOptions options;
    options.shape = shape;
    options.costs = costs;
    return DeviceRefitter(shared_context(), options);
}

void expect_costs(const std::vector<float>& sah, double before, double after) {
    CHECK(sah[0] == Approx(before).epsilon(1e-6));
    CHECK(sah[1] == Approx(after).epsilon(1e-6));
}

RefitMemory::RefitMemory(const DeviceRefitter& refitter, const Bvh& tree, const Mesh& mesh)
    : tree_(tree),
      sizes_(refitter.sizes(static_cast<std::uint32_t>(tree.nodes.size()),
                            static_cast<std::uint32_t>(mesh.triangles.size()))),
      nodes_(uploaded(tree.nodes)),
      ids_(uploaded(tree.primitive_ids)),
      vertices_(uploaded(mesh.vertices)),
      indices_(uploaded(mesh.triangles)),
      order_(filled_buffer(sizes_.order)),
      scratch_(filled_buffer(std::max(sizes_.scratch, sizes_.cost_scratch))),
      sah_(filled_buffer(16)) {
    triangles_.count = static_cast<std::uint32_t>(mesh.triangles.size());
    triangles_.vertices = {vertices_()};
    triangles_.indices = {indices_()};
}

Bvh RefitMemory::read_tree() const {
    Bvh tree = tree_;
    tree.nodes = read<Node>(nodes_, tree_.nodes.size());
    return tree;
}

std::vector<float> RefitMemory::read_sah() const {
    std::vector<float> values = read<float>(sah_, 3);
    return {values[1], values[2]};
}

void RefitMemory::move(const Mesh& moved) const {
    write(vertices_, moved.vertices);
}

}  // namespace clbvh::test
