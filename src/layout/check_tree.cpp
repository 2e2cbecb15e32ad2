#include "layout/check_tree.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "clbvh/core/error.hpp"
#include "core/own_group.hpp"
#include "core/primitive_access.hpp"
#include "core/tree_walk.hpp"
#include "core/view_form.hpp"
#include "layout/depth_first.hpp"

namespace clbvh::layout {
namespace {

[[noreturn]] void reject(const std::string& fault) {
    throw Error(ErrorCode::invalid_input,
                "the tree cannot be traced: " + fault + "; give a tree that was built over this mesh");
}

void check_count(const Bvh& bvh, const MeshView& mesh) {
    if (bvh.primitive_count != mesh.triangle_count) {
        reject("it is over " + std::to_string(bvh.primitive_count) + " primitives, the mesh has " +
               std::to_string(mesh.triangle_count) + " triangles");
    }
}

/// Throws for the first id that is out of range, or has a triangle with a vertex that is.
void name_primitive(const Bvh& bvh, const MeshView& mesh) {
    for (const std::uint32_t primitive : bvh.primitive_ids) {
        if (primitive >= mesh.triangle_count) {
            reject("primitive " + std::to_string(primitive) + " is out of range, the mesh has " +
                   std::to_string(mesh.triangle_count) + " triangles");
        }
        for (const std::uint32_t vertex : mesh.triangle(primitive)) {
            if (vertex < mesh.vertex_count) continue;
            reject("triangle " + std::to_string(primitive) + " has vertex " + std::to_string(vertex) +
                   ", the mesh has " + std::to_string(mesh.vertex_count) + " vertices");
        }
    }
}

/// Throws for the first node, in traversal order, for which the tree is none.
[[noreturn]] void name_node_with_fault(const Bvh& bvh) {
    TreeWalk walk(bvh);
    std::uint64_t references = 0;
    while (walk.next()) {
        references += bvh.nodes[walk.node()].count;
        if (references > bvh.primitive_ids.size())
            reject("leaves share primitive ids, the last at " + name_node(walk.node()));
    }
    reject(walk.failed() ? walk.fault() : "its nodes are no tree");
}

/// True where `is_wrong` of any number below `count` is, in parallel.
template <typename IsWrong>
bool any_of(std::size_t count, const IsWrong& is_wrong) {
    constexpr std::size_t kAtOnce = 32768;
    std::atomic<bool> found = false;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kAtOnce), [&](const auto& range) {
        bool is_any_wrong = false;
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            is_any_wrong |= is_wrong(i);
        if (is_any_wrong) found.store(true, std::memory_order_relaxed);
    });
    return found.load(std::memory_order_relaxed);
}

/// True where a primitive may be out of range, or a vertex of one: triangles that are not in the tree count, too.
/// Leaves can refer to any range of ids if not.
bool may_have_wrong_primitive(const Bvh& bvh, const MeshView& mesh) {
    const std::uint32_t* const ids = bvh.primitive_ids.data();
    if (any_of(bvh.primitive_ids.size(), [&](std::size_t i) { return ids[i] >= mesh.triangle_count; })) return true;
    if (mesh.indices == nullptr) return false;  // check_form() has looked at that
    return with_triangles(mesh, [&](const auto& triangles) {
        return any_of(triangles.count, [&](std::size_t i) {
            return triangles.index(i, 0) >= triangles.vertex_count || triangles.index(i, 1) >= triangles.vertex_count ||
                   triangles.index(i, 2) >= triangles.vertex_count;
        });
    });
}

/// The depth of the tree; nothing where it is none.
std::optional<std::uint32_t> find_depth(const Bvh& bvh) {
    std::vector<std::atomic<std::uint8_t>> pairs(bvh.nodes.size() / 2);
    const std::optional<TreeParts> tree = find_parts(bvh, pairs.data());
    if (!tree) return std::nullopt;
    std::size_t with_parent = 0;
    for (const std::atomic<std::uint8_t>& pair : pairs)
        with_parent += pair.load(std::memory_order_relaxed);
    if (with_parent != tree->parts[0].node_count / 2) return std::nullopt;
    return tree->depth;
}

}  // namespace

/// What is quick to find, in parallel, is whether there is a fault; which is the first takes a walk in order.
std::uint32_t check_tree(const Bvh& bvh, const MeshView& mesh) {
    check_form(mesh);
    check_count(bvh, mesh);
    return in_own_group([&]() -> std::uint32_t {
        if (may_have_wrong_primitive(bvh, mesh)) name_primitive(bvh, mesh);
        if (bvh.empty()) return 0;
        const std::optional<std::uint32_t> depth = find_depth(bvh);
        if (!depth) name_node_with_fault(bvh);
        return *depth;
    });
}

}  // namespace clbvh::layout
