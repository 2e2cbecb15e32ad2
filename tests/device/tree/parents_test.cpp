// Parent links: each sibling pair in use names the slot of its parent, in both shapes.
#include "device/tree/parents.hpp"

#include <catch2/catch.hpp>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::uint32_t kUntouched = 0xabababab;

std::vector<std::uint32_t> expected_parents(const std::vector<Node>& nodes, std::size_t in_use) {
    std::vector<std::uint32_t> parents(nodes.size() / 2, kUntouched);
    for (std::uint32_t slot = 0; slot < in_use; ++slot) {
        if (!nodes[slot].is_leaf() && nodes[slot].first != 0) parents[nodes[slot].first / 2] = slot;
    }
    return parents;
}

/// Checks both shapes on `nodes`; where `active_count` is not 0 it is given to the kernel.
void expect_parents(const std::vector<Node>& nodes, std::uint32_t active_count) {
    const std::size_t in_use = active_count > 0 ? 2 * std::size_t{active_count} : nodes.size();
    const device::Session& session = shared_context().session();
    device::TreeNodes tree;
    tree.nodes = cl::Buffer(session.context(), CL_MEM_READ_WRITE, nodes.size() * sizeof(Node));
    tree.node_count = static_cast<std::uint32_t>(nodes.size());
    write(tree.nodes, nodes);
    if (active_count > 0) {
        tree.active_count = {cl::Buffer(session.context(), CL_MEM_READ_WRITE, 8), 4};
        write(tree.active_count.buffer, std::vector{std::uint32_t{7}, active_count});
    }
    const cl::Buffer parents(session.context(), CL_MEM_READ_WRITE, nodes.size() / 2 * sizeof(cl_uint));
    for (const std::size_t work_group_size : {1u, 64u}) {
        INFO(nodes.size() << " nodes, work groups of " << work_group_size);
        fill_bytes(parents, 0xab);
        StageBench bench(BuildOptions{}, 1);
        device::launch_parents(bench.launcher, work_group_size, tree, parents);
        CHECK(read<std::uint32_t>(parents, nodes.size() / 2) == expected_parents(nodes, in_use));
    }
}

}  // namespace

TEST_CASE("parents: of device trees, whose size may be known on the device alone") {
    for (const std::size_t count : {1u, 2u, 3u, 1000u, 2048u, 2049u, 9000u}) {
        std::vector<Node> nodes = make_builder("lbvh").build(random_triangles(count)).nodes;
        expect_parents(nodes, 0);
        const auto active = static_cast<std::uint32_t>(count);
        // Memory behind the nodes in use looks like a node, but is not one.
        nodes.resize(nodes.size() + 200, Node{{0, 0, 0}, 2, {1, 1, 1}, 0});
        expect_parents(nodes, active);
    }
}

TEST_CASE("parents: of host trees, where slots that no node uses are zero") {
    Bvh tree = make_builder("binned-sah").build(random_triangles(5000));
    tree.nodes.resize(tree.nodes.size() + 100);
    expect_parents(tree.nodes, 0);
}
