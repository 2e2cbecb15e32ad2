#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "clbvh/core/bvh.hpp"
#include "clbvh/core/ray.hpp"
#include "clbvh/trace/box_tests.hpp"
#include "clbvh/trace/node_stack.hpp"

namespace clbvh {

/// The function that traverse() calls for a leaf: the primitives are primitive_ids[first .. first + count), t_max is
/// where the ray ends now. It may lower t_max, never raise it; false ends the traversal.
template <typename Leaf>
concept LeafVisitor = requires(Leaf leaf, std::uint32_t first, std::uint32_t count, float& t_max) {
    { leaf(first, count, t_max) } -> std::convertible_to<bool>;
};

inline namespace CLBVH_BOX_TESTS_NAMESPACE {
namespace detail {

/// Counts nothing, at no cost.
struct NoRayCounts {
    static constexpr void add_inner_node() noexcept {}
    static constexpr void add_leaf() noexcept {}
};

struct CountingRayCounts {
    RayCounts& counts;
    void add_inner_node() const noexcept { ++counts.inner_nodes; }
    void add_leaf() const noexcept { ++counts.leaves; }
};

/// The deferred node that is next, or null where none is left that the ray enters before t_max.
template <typename Stack>
const Node* next_node(Stack& stack, const float& t_max) noexcept {
    while (!stack.empty()) {
        const DeferredNode deferred = stack.pop();
        if (reaches(t_max, deferred.t)) return deferred.node;
    }
    return nullptr;
}

/// `nodes` is a tree that is not empty; `Stack` a stack of DeferredNode that is deep enough.
template <typename Stack, typename Counts, LeafVisitor Leaf>
void traverse(const Node* nodes, const Ray& ray, Leaf& leaf, Counts counts, Stack& stack) {
    if (!is_traceable(ray)) return;
    const RaySlabs slabs(ray);
    float t_max = ray.t_max;
    if (!slabs.meets(nodes[0].bounds(), t_max)) return;
    const ChildBoxTest test_boxes(slabs);
    const Node* node = &nodes[0];
    for (;;) {
        if (node->is_leaf()) {
            counts.add_leaf();
            if (!leaf(node->first, node->count, t_max)) return;
        } else {
            counts.add_inner_node();
            const Node* const children = &nodes[node->first];
            ChildEntries entries;
            test_boxes(children, t_max, entries);
            if (entries.is_met[0] && entries.is_met[1]) {
                const unsigned near = near_child(entries);
                stack.push({&children[1 - near], entries.t[1 - near]});
                node = &children[near];
                continue;
            }
            if (entries.is_met[0] || entries.is_met[1]) {
                node = &children[entries.is_met[0] ? 0 : 1];
                continue;
            }
        }
        node = next_node(stack, t_max);
        if (node == nullptr) return;
    }
}

}  // namespace detail

/// Traces a ray through a tree over primitives of any kind and calls `leaf` for every leaf whose box it meets, near
/// ones first: of two children the one that the ray enters first, then the other, unless `leaf` has lowered t_max below
/// where the ray enters it. A closest hit lowers t_max to its t; whoever wants all hits leaves t_max alone; whoever
/// wants to know only whether there is one returns false.
///
///     float nearest = ray.t_max;
///     clbvh::traverse(bvh.nodes, ray, [&](std::uint32_t first, std::uint32_t count, float& t_max) {
///         for (std::uint32_t i = first; i < first + count; ++i)
///             if (const auto t = intersect(shapes[bvh.primitive_ids[i]], ray, t_max)) nearest = t_max = *t;
///         return true;
///     });
///
/// The box test is that of Ize 2013, "Robust BVH Ray Traversal", with a larger margin (kBoxSlack): a box is left out
/// only where the ray's part from max(t_min, 0) to t_max surely misses it. A ray that is not is_traceable visits
/// nothing. `nodes` is empty or a tree as Bvh documents it; that is not checked. Any depth will do: beyond 64 deferred
/// nodes the stack moves to the heap.
template <LeafVisitor Leaf>
void traverse(std::span<const Node> nodes, const Ray& ray, Leaf&& leaf) {
    if (nodes.empty()) return;
    GrowingNodeStack stack;
    detail::traverse(nodes.data(), ray, leaf, detail::NoRayCounts{}, stack);
}

/// The same, and adds the inner nodes and leaves visited to `counts`. How many primitives were tested only `leaf`
/// knows.
template <LeafVisitor Leaf>
void traverse(std::span<const Node> nodes, const Ray& ray, Leaf&& leaf, RayCounts& counts) {
    if (nodes.empty()) return;
    GrowingNodeStack stack;
    detail::traverse(nodes.data(), ray, leaf, detail::CountingRayCounts{counts}, stack);
}

}  // namespace CLBVH_BOX_TESTS_NAMESPACE
}  // namespace clbvh
