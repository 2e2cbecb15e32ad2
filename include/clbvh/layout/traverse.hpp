#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clbvh/core/ray.hpp"
#include "clbvh/layout/compressed8.hpp"
#include "clbvh/layout/pair.hpp"
#include "clbvh/layout/skip.hpp"
#include "clbvh/layout/triangle_block.hpp"
#include "clbvh/layout/wide.hpp"
#include "clbvh/trace/box_tests.hpp"
#include "clbvh/trace/traverse.hpp"

namespace clbvh {

/// The function that traverse() calls for a leaf of a wide layout, with its blocks. t_max is where the ray ends now: it
/// may lower that, never raise it; false ends the traversal.
template <typename Leaf>
concept BlockVisitor = requires(Leaf leaf, std::span<const TriangleBlock> blocks, float& t_max) {
    { leaf(blocks, t_max) } -> std::convertible_to<bool>;
};

/// The same for a leaf of a Compressed8, with its triangles.
template <typename Leaf>
concept TriangleVisitor = requires(Leaf leaf, std::span<const Compressed8Triangle> triangles, float& t_max) {
    { leaf(triangles, t_max) } -> std::convertible_to<bool>;
};

inline namespace CLBVH_BOX_TESTS_NAMESPACE {
namespace detail {

/// A child whose nearer siblings go first, and where the ray enters it.
struct DeferredChild {
    std::uint32_t child;
    float t;
};

/// Room for all children that one ray can defer in a tree with `width` children a node: on the stack, or on the heap
/// for trees of an unusual depth.
class ChildStack {
public:
    ChildStack(std::uint32_t depth, std::uint32_t width) {
        const std::size_t most = std::size_t{depth} * (width - 1) + 1;
        if (most <= few_.size()) return;
        many_.resize(most);
        entries_ = many_.data();
    }
    [[nodiscard]] DeferredChild* entries() noexcept { return entries_; }

private:
    std::array<DeferredChild, 256> few_;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by push
    std::vector<DeferredChild> many_;
    DeferredChild* entries_ = few_.data();
};

/// Puts a child onto the stack, in its place among those from `bottom` on, far ones first. Returns the stack's new end.
inline DeferredChild* defer_child(DeferredChild* top, const DeferredChild* bottom,
                                  const DeferredChild& child) noexcept {
    DeferredChild* place = top++;
    for (; place > bottom && place[-1].t < child.t; --place)
        place[0] = place[-1];
    *place = child;
    return top;
}

/// Takes the child that is next off the stack, which begins at `bottom`. False where none is left that the ray enters
/// before t_max.
inline bool take_next(DeferredChild*& top, const DeferredChild* bottom, const float& t_max,
                      std::uint32_t& child) noexcept {
    while (top != bottom) {
        --top;
        if (!reaches(t_max, top->t)) continue;
        child = top->child;
        return true;
    }
    return false;
}

#if defined(CLBVH_TRACE_HAS_SSE2) && !defined(CLBVH_CALLS_BOX_TESTS)

/// A ray against the boxes of a node's children: where it enters each, and one bit for each that it meets up to t_max.
template <std::uint32_t Width>
class WideBoxTest {
public:
    explicit WideBoxTest(const RaySlabs& slabs) noexcept : t_min_(_mm_set1_ps(slabs.t_min())) {
        for (unsigned axis = 0; axis < 3; ++axis) {
            near_[axis] = slabs.enters_high(axis) ? 1 : 0;
            origin_[axis] = _mm_set1_ps(slabs.origin(axis));
            inverse_[axis] = _mm_set1_ps(slabs.inverse(axis));
        }
    }

    std::uint32_t operator()(const WideNode<Width>& node, const float& t_max,
                             std::array<float, Width>& entries) const noexcept {
        std::uint32_t met = 0;
        for (std::uint32_t begin = 0; begin < Width; begin += 4) {
            __m128 entry = t_min_, exit = _mm_set1_ps(t_max);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto plane = [&](std::size_t side) {
                    const __m128 planes = _mm_load_ps(node.bounds[side][axis].data() + begin);
                    return _mm_mul_ps(_mm_sub_ps(planes, origin_[axis]), inverse_[axis]);
                };
                // Of a NaN and another these are the other, their second operand.
                entry = _mm_max_ps(plane(near_[axis]), entry);
                exit = _mm_min_ps(plane(1 - near_[axis]), exit);
            }
            _mm_storeu_ps(entries.data() + begin, entry);
            const __m128 is_met = _mm_cmple_ps(entry, _mm_mul_ps(exit, _mm_set1_ps(kBoxSlack)));
            met |= static_cast<std::uint32_t>(_mm_movemask_ps(is_met)) << begin;
        }
        return met;
    }

private:
    __m128 t_min_;
    __m128 origin_[3];
    __m128 inverse_[3];
    std::size_t near_[3];
};

#else

template <std::uint32_t Width>
class WideBoxTest {
public:
    explicit WideBoxTest(const RaySlabs& slabs) noexcept : slabs_(slabs) {}

    std::uint32_t operator()(const WideNode<Width>& node, const float& t_max,
                             std::array<float, Width>& entries) const noexcept {
        std::uint32_t met = 0;
        for (std::uint32_t i = 0; i < Width; ++i) {
            const auto& [lower, upper] = node.bounds;
            const Aabb box{{lower[0][i], lower[1][i], lower[2][i]}, {upper[0][i], upper[1][i], upper[2][i]}};
            entries[i] = slabs_.entry(box);
            met |= (slabs_.meets(box, t_max) ? 1U : 0U) << i;
        }
        return met;
    }

private:
    RaySlabs slabs_;
};

#endif

/// Puts the children of `node` that are met onto the stack, far ones first. Returns its new end.
template <std::uint32_t Width>
DeferredChild* defer_children(const WideNode<Width>& node, const std::array<float, Width>& entries, std::uint32_t met,
                              DeferredChild* const bottom) noexcept {
    DeferredChild* top = bottom;
    for (std::uint32_t i = 0; i < Width; ++i) {
        if ((met >> i & 1U) == 0 || node.children[i] == WideChild::kNone) continue;
        top = defer_child(top, bottom, {node.children[i], entries[i]});
    }
    return top;
}

}  // namespace detail

/// Traces a ray through a wide layout and calls `leaf` for every leaf whose box it meets, near ones first: of the
/// children of a node those that the ray enters first, unless `leaf` has lowered t_max below where the ray enters them.
/// A closest hit lowers t_max to its t; whoever wants all hits leaves t_max alone; whoever wants to know only whether
/// there is one returns false.
///
///     clbvh::traverse(layout, ray, [&](std::span<const clbvh::TriangleBlock> blocks, float& t_max) {
///         for (const clbvh::TriangleBlock& block : blocks)
///             intersect(block, ray, t_max);
///         return true;
///     });
///
/// Boxes are tested as by traverse() of binary trees (clbvh/trace/traverse.hpp). A ray that is not is_traceable visits
/// nothing. `layout` is one that make_layout() made; that is not checked. Any depth will do: for trees of an unusual
/// one the stack moves to the heap, which may throw std::bad_alloc. Triangles that stand in a block for none are NaN,
/// and their primitive is kNoPrimitive. For the library's own hits use Tracer, which is faster.
template <std::uint32_t Width, BlockVisitor Leaf>
void traverse(const WideLayout<Width>& layout, const Ray& ray, Leaf&& leaf) {
    if (layout.empty() || !is_traceable(ray)) return;
    const detail::WideBoxTest<Width> test_boxes{RaySlabs(ray)};
    detail::ChildStack stack(layout.depth, Width);
    detail::DeferredChild* top = stack.entries();
    float t_max = ray.t_max;
    std::uint32_t child = 0;
    for (;;) {
        if (WideChild::is_leaf(child)) {
            const std::span<const TriangleBlock> blocks(layout.blocks.data(), layout.blocks.size());
            if (!leaf(blocks.subspan(WideChild::first_block(child), WideChild::block_count(child)), t_max)) return;
        } else {
            const WideNode<Width>& node = layout.nodes[child];
            std::array<float, Width> entries;
            const std::uint32_t met = test_boxes(node, t_max, entries);
            top = detail::defer_children<Width>(node, entries, met, top);
        }
        if (!detail::take_next(top, stack.entries(), t_max, child)) return;
    }
}

/// The same through a layout of pairs: `leaf` is called as for binary trees (clbvh/trace/traverse.hpp), with places in
/// the layout's primitive_ids. A tree that is one leaf has no box: that leaf is always visited.
template <LeafVisitor Leaf>
void traverse(const PairLayout& layout, const Ray& ray, Leaf&& leaf) {
    if (layout.empty() || !is_traceable(ray)) return;
    const ChildBoxTest test_boxes{RaySlabs(ray)};
    detail::ChildStack stack(layout.depth, 2);
    detail::DeferredChild* top = stack.entries();
    float t_max = ray.t_max;
    std::uint32_t number = 0;
    for (;;) {
        const PairNode& node = layout.nodes[number];
        if (node.is_leaf()) {
            if (!leaf(node.first, node.count, t_max)) return;
        } else {
            // Boxes are where those of two nodes side by side are.
            const auto boxes = std::bit_cast<std::array<Node, 2>>(node);
            const std::array<std::uint32_t, 2> children{node.left, node.right};
            ChildEntries entries;
            test_boxes(boxes.data(), t_max, entries);
            const bool are_both_met = entries.is_met[0] && entries.is_met[1];
            const unsigned near = are_both_met ? near_child(entries) : entries.is_met[0] ? 0 : 1;
            if (are_both_met) *top++ = {children[1 - near], entries.t[1 - near]};
            if (entries.is_met[near]) {
                number = children[near];
                continue;
            }
        }
        if (!detail::take_next(top, stack.entries(), t_max, number)) return;
    }
}

/// The same through a layout with skip links, in the order of its nodes, which is not that of the ray: lower t_max all
/// the same, to leave out what is behind.
template <LeafVisitor Leaf>
void traverse(const SkipLayout& layout, const Ray& ray, Leaf&& leaf) {
    if (!is_traceable(ray)) return;
    const RaySlabs slabs(ray);
    float t_max = ray.t_max;
    for (std::size_t i = 0; i < layout.nodes.size();) {
        const SkipNode& node = layout.nodes[i];
        const bool is_met = slabs.meets(node.bounds(), t_max);
        if (is_met && node.is_leaf() && !leaf(node.link, node.count, t_max)) return;
        i = is_met || node.is_leaf() ? i + 1 : node.link;
    }
}

/// The same through a compressed layout: `leaf` is called with a leaf's triangles. Leaves of a node are visited before
/// its nodes, roughly from near to far, then the nodes, near ones first. Boxes are larger than those of the tree, so
/// that more leaves are visited, and the vertices that a triangle's edges lead to are rounded: for a watertight test,
/// and for the hits of Tracer, take those of the mesh.
template <TriangleVisitor Leaf>
void traverse(const Compressed8& layout, const Ray& ray, Leaf&& leaf) {
    if (layout.empty() || !is_traceable(ray)) return;
    const RaySlabs slabs(ray);
    const std::uint32_t octant =
        (slabs.enters_high(0) ? 4U : 0U) | (slabs.enters_high(1) ? 2U : 0U) | (slabs.enters_high(2) ? 1U : 0U);
    const std::span<const Compressed8Triangle> triangles(layout.triangles.data(), layout.triangles.size());
    detail::ChildStack stack(layout.depth, 8);
    detail::DeferredChild* top = stack.entries();
    float t_max = ray.t_max;
    std::uint32_t number = 0;
    do {
        const Compressed8Node& node = layout.nodes[number];
        const detail::DeferredChild* const bottom = top;
        for (std::uint32_t place = 0; place < 8; ++place) {
            const std::uint32_t slot = place ^ octant;
            if (node.is_empty(slot)) continue;
            const Aabb box = node.bounds(slot);
            if (!slabs.meets(box, t_max)) continue;
            if (node.is_inner(slot)) {
                top = detail::defer_child(top, bottom, {node.child(slot), slabs.entry(box)});
            } else if (!leaf(triangles.subspan(node.triangle(slot), node.triangle_count(slot)), t_max)) {
                return;
            }
        }
    } while (detail::take_next(top, stack.entries(), t_max, number));
}

}  // namespace CLBVH_BOX_TESTS_NAMESPACE
}  // namespace clbvh
