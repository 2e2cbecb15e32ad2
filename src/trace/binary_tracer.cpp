#include "clbvh/trace/binary_tracer.hpp"

#include <tbb/task_arena.h>

#include <string>
#include <utility>
#include <vector>

#include "clbvh/core/error.hpp"
#include "clbvh/trace/traverse.hpp"
#include "core/arena_size.hpp"
#include "core/check_field.hpp"
#include "core/check_length.hpp"
#include "core/memory_errors.hpp"
#include "core/own_group.hpp"
#include "layout/check_tree.hpp"
#include "trace/leaf_triangles.hpp"
#include "trace/ray_tasks.hpp"

namespace clbvh {
using namespace trace;

struct CLBVH_NO_EXPORT BinaryTracer::State {
    State(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options)
        : triangle_test(options.triangle_test),
          arena(arena_size_for(options)),
          depth(execute_in(arena, [&] { return layout::check_tree(bvh, mesh); })),
          nodes(bvh.nodes),
          triangles(execute_in(arena, [&] { return copy_triangles(bvh, mesh); })) {}

    /// Calls `leaf` for the leaves that the ray visits.
    template <typename Counts, typename Leaf>
    void walk(const Ray& ray, Leaf& leaf, Counts counts) const {
        if (nodes.empty()) return;
        if (depth <= FixedNodeStack::kCapacity) {
            FixedNodeStack stack;
            detail::traverse(nodes.data(), ray, leaf, counts, stack);
        } else {
            with_memory_errors("the stack of a ray", [&] {
                GrowingNodeStack stack;
                detail::traverse(nodes.data(), ray, leaf, counts, stack);
            });
        }
    }

    /// Calls `action` with the test that the options name as template argument.
    template <typename Action>
    decltype(auto) with_test(const Action& action) const {
        if (triangle_test == TriangleTest::watertight) return action.template operator()<WatertightTest>();
        return action.template operator()<MollerTrumboreTest>();
    }

    template <typename Counts>
    [[nodiscard]] std::pair<Hit, std::uint32_t> closest(const Ray& ray, Counts counts) const {
        return with_test([&]<typename Test>() {
            ClosestLeaf<Test> leaf(triangles.data(), ray);
            walk(ray, leaf, counts);
            return std::pair(leaf.hit(), leaf.tested());
        });
    }

    template <typename Counts>
    [[nodiscard]] std::pair<bool, std::uint32_t> any(const Ray& ray, Counts counts) const {
        return with_test([&]<typename Test>() {
            AnyLeaf<Test> leaf(triangles.data(), ray);
            walk(ray, leaf, counts);
            return std::pair(leaf.is_hit(), leaf.tested());
        });
    }

    TriangleTest triangle_test;
    mutable tbb::task_arena arena;
    std::uint32_t depth;
    std::vector<Node> nodes;
    std::vector<LeafTriangle> triangles;  ///< In the order of Bvh::primitive_ids.
};

BinaryTracer::BinaryTracer(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options)
    : state_(
          with_memory_errors("the binary tracer", [&] { return std::make_unique<const State>(bvh, mesh, options); })) {}
BinaryTracer::BinaryTracer(BinaryTracer&&) noexcept = default;
BinaryTracer& BinaryTracer::operator=(BinaryTracer&&) noexcept = default;
BinaryTracer::~BinaryTracer() = default;

Hit BinaryTracer::closest(const Ray& ray, RayCounts& counts) const {
    const auto [hit, tested] = state_->closest(ray, detail::CountingRayCounts{counts});
    counts.triangles += tested;
    return hit;
}

bool BinaryTracer::any(const Ray& ray, RayCounts& counts) const {
    const auto [is_hit, tested] = state_->any(ray, detail::CountingRayCounts{counts});
    counts.triangles += tested;
    return is_hit;
}

RayCounts BinaryTracer::visits(const Ray& ray) const {
    RayCounts counts;
    auto leaf = [&](std::uint32_t, std::uint32_t count, float&) {
        counts.triangles += count;
        return true;
    };
    state_->walk(ray, leaf, detail::CountingRayCounts{counts});
    return counts;
}

void BinaryTracer::closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) const {
    check_length("hits", hits.size(), rays.size());
    check_length("counts", counts.size(), rays.size());
    for_each_ray(state_->arena, rays.size(), [&](std::size_t i) {
        counts[i] = {};
        hits[i] = closest(rays[i], counts[i]);
    });
}

void BinaryTracer::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) const {
    check_length("is_hit", is_hit.size(), rays.size());
    check_length("counts", counts.size(), rays.size());
    for_each_ray(state_->arena, rays.size(), [&](std::size_t i) {
        counts[i] = {};
        is_hit[i] = any(rays[i], counts[i]) ? 1 : 0;
    });
}

void BinaryTracer::visits(std::span<const Ray> rays, std::span<RayCounts> counts) const {
    check_length("counts", counts.size(), rays.size());
    for_each_ray(state_->arena, rays.size(), [&](std::size_t i) { counts[i] = visits(rays[i]); });
}

std::uint32_t BinaryTracer::depth() const noexcept {
    return state_->depth;
}

}  // namespace clbvh
