#include "clbvh/trace/tracer.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
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
#include "trace/check_tree.hpp"
#include "trace/leaf_triangles.hpp"
#include "trace/wide_tracing.hpp"
#include "trace/wide_tree.hpp"

namespace clbvh {
namespace {

using namespace trace;

/// Rays of one task of the calls for many.
constexpr std::size_t kRaysPerTask = 256;

int arena_size_for(const TracerOptions& options) {
    check_range("thread_count", options.thread_count, 0, 1024);
    return arena_size(options.thread_count);
}

}  // namespace

struct CLBVH_NO_EXPORT Tracer::State {
    State(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options)
        : triangle_test(options.triangle_test),
          arena(arena_size_for(options)),
          depth(check_tree(bvh, mesh)),
          nodes(bvh.nodes),
          triangles(arena.execute([&] { return copy_triangles(bvh, mesh); })),
          wide_tree(make_wide_tree(nodes, triangles)),
          wide(wide_tracing(simd::instruction_set(), options.triangle_test)) {
        simd::check_instruction_set();
    }

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

    /// Calls `action` with every index below `count`, in parallel.
    template <typename Action>
    void for_each(std::size_t count, const Action& action) const {
        arena.execute([&] {
            tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kRaysPerTask), [&](const auto& range) {
                for (std::size_t i = range.begin(); i < range.end(); ++i)
                    action(i);
            });
        });
    }

    TriangleTest triangle_test;
    mutable tbb::task_arena arena;
    std::uint32_t depth;
    std::vector<Node> nodes;
    std::vector<LeafTriangle> triangles;  ///< In the order of Bvh::primitive_ids.
    WideTree wide_tree;                   ///< What is traced where nothing is counted.
    WideTracing wide;
};

Tracer::Tracer(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options)
    : state_(with_memory_errors("the tracer", [&] { return std::make_unique<const State>(bvh, mesh, options); })) {}
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;
Tracer::~Tracer() = default;

Hit Tracer::closest(const Ray& ray) const {
    return state_->wide.closest(state_->wide_tree, ray);
}

bool Tracer::any(const Ray& ray) const {
    return state_->wide.any(state_->wide_tree, ray);
}

Hit Tracer::closest(const Ray& ray, RayCounts& counts) const {
    const auto [hit, tested] = state_->closest(ray, detail::CountingRayCounts{counts});
    counts.triangles += tested;
    return hit;
}

bool Tracer::any(const Ray& ray, RayCounts& counts) const {
    const auto [is_hit, tested] = state_->any(ray, detail::CountingRayCounts{counts});
    counts.triangles += tested;
    return is_hit;
}

void Tracer::all(const Ray& ray, const std::function<bool(const Hit&)>& visit) const {
    const std::vector<Hit> hits = with_memory_errors("the hits of a ray", [&] {
        return state_->with_test([&]<typename Test>() {
            AllLeaf<Test> leaf(state_->triangles.data(), ray);
            state_->walk(ray, leaf, detail::NoRayCounts{});
            return leaf.take_hits();
        });
    });
    for (const Hit& hit : hits) {
        if (!visit(hit)) return;
    }
}

RayCounts Tracer::visits(const Ray& ray) const {
    RayCounts counts;
    auto leaf = [&](std::uint32_t, std::uint32_t count, float&) {
        counts.triangles += count;
        return true;
    };
    state_->walk(ray, leaf, detail::CountingRayCounts{counts});
    return counts;
}

void Tracer::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
    check_length("hits", hits.size(), rays.size());
    state_->for_each(rays.size(), [&](std::size_t i) { hits[i] = closest(rays[i]); });
}

void Tracer::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) const {
    check_length("is_hit", is_hit.size(), rays.size());
    state_->for_each(rays.size(), [&](std::size_t i) { is_hit[i] = any(rays[i]) ? 1 : 0; });
}

void Tracer::closest(std::span<const Ray> rays, std::span<Hit> hits, std::span<RayCounts> counts) const {
    check_length("hits", hits.size(), rays.size());
    check_length("counts", counts.size(), rays.size());
    state_->for_each(rays.size(), [&](std::size_t i) {
        counts[i] = {};
        hits[i] = closest(rays[i], counts[i]);
    });
}

void Tracer::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, std::span<RayCounts> counts) const {
    check_length("is_hit", is_hit.size(), rays.size());
    check_length("counts", counts.size(), rays.size());
    state_->for_each(rays.size(), [&](std::size_t i) {
        counts[i] = {};
        is_hit[i] = any(rays[i], counts[i]) ? 1 : 0;
    });
}

void Tracer::visits(std::span<const Ray> rays, std::span<RayCounts> counts) const {
    check_length("counts", counts.size(), rays.size());
    state_->for_each(rays.size(), [&](std::size_t i) { counts[i] = visits(rays[i]); });
}

std::uint32_t Tracer::depth() const noexcept {
    return state_->depth;
}

}  // namespace clbvh
