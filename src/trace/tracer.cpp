#include "clbvh/trace/tracer.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "clbvh/layout/wide.hpp"
#include "core/check_length.hpp"
#include "core/memory_errors.hpp"
#include "trace/leaf_triangles.hpp"
#include "trace/ray_tasks.hpp"
#include "trace/wide_tracing.hpp"

namespace clbvh {
namespace {

using namespace trace;

/// Orders the hits of a ray by t, then by primitive, and leaves one of each primitive.
void put_in_order(std::vector<Hit>& hits) {
    std::ranges::sort(hits, [](const Hit& a, const Hit& b) { return is_closer(a.t, a.primitive, b); });
    const auto is_same = [](const Hit& a, const Hit& b) { return a.primitive == b.primitive; };
    hits.erase(std::unique(hits.begin(), hits.end(), is_same), hits.end());
}

}  // namespace

struct CLBVH_NO_EXPORT Tracer::State {
    State(Wide8&& layout, const TracerOptions& options) : State(options) {
        owned = std::move(layout);
        traced = &owned;
    }
    State(const Wide8* layout, const TracerOptions& options) : State(options) { traced = layout; }
    explicit State(const TracerOptions& options)
        : arena(arena_size_for(options)), wide(wide_tracing(simd::instruction_set(), options.triangle_test)) {
        simd::check_instruction_set();
    }

    [[nodiscard]] Hit closest(const Ray& ray) const { return wide.closest(*traced, ray); }
    [[nodiscard]] bool any(const Ray& ray) const { return wide.any(*traced, ray); }
    void all(const Ray& ray, std::vector<Hit>& hits) const {
        hits.clear();
        wide.all(*traced, ray, hits);
        put_in_order(hits);
    }

    mutable tbb::task_arena arena;
    WideTracing wide;
    Wide8 owned;  // where the layout is the tracer's
    const Wide8* traced = nullptr;
};

namespace {

Wide8 layout_of(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options) {
    return make_layout<Wide8>(bvh, mesh, {.thread_count = options.thread_count});
}

}  // namespace

Tracer::Tracer(const Bvh& bvh, const MeshView& mesh, const TracerOptions& options)
    : Tracer(layout_of(bvh, mesh, options), options) {}
Tracer::Tracer(Wide8&& layout, const TracerOptions& options)
    : state_(with_memory_errors("the tracer",
                                [&] { return std::make_unique<const State>(std::move(layout), options); })) {}
Tracer::Tracer(const Wide8& layout, const TracerOptions& options)
    : state_(with_memory_errors("the tracer", [&] { return std::make_unique<const State>(&layout, options); })) {}
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;
Tracer::~Tracer() = default;

Hit Tracer::closest(const Ray& ray) const {
    return state_->closest(ray);
}

bool Tracer::any(const Ray& ray) const {
    return state_->any(ray);
}

Hit Tracer::closest(const Ray& ray, const HitFilter& filter) const {
    return state_->wide.closest_filtered(*state_->traced, ray, filter);
}

bool Tracer::any(const Ray& ray, const HitFilter& filter) const {
    return state_->wide.any_filtered(*state_->traced, ray, filter);
}

void Tracer::all(const Ray& ray, const std::function<bool(const Hit&)>& visit) const {
    std::vector<Hit> hits;
    with_memory_errors("the hits of a ray", [&] { state_->all(ray, hits); });
    for (const Hit& hit : hits) {
        if (!visit(hit)) return;
    }
}

void Tracer::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
    check_length("hits", hits.size(), rays.size());
    for_each_piece(state_->arena, rays.size(), [&](std::size_t begin, std::size_t end) {
        state_->wide.closest_of_many(*state_->traced, rays.subspan(begin, end - begin), hits.data() + begin);
    });
}

void Tracer::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit) const {
    check_length("is_hit", is_hit.size(), rays.size());
    for_each_piece(state_->arena, rays.size(), [&](std::size_t begin, std::size_t end) {
        state_->wide.any_of_many(*state_->traced, rays.subspan(begin, end - begin), is_hit.data() + begin);
    });
}

void Tracer::closest(std::span<const Ray> rays, std::span<Hit> hits, const HitFilter& filter) const {
    check_length("hits", hits.size(), rays.size());
    for_each_ray(state_->arena, rays.size(), [&](std::size_t i) { hits[i] = closest(rays[i], filter); });
}

void Tracer::any(std::span<const Ray> rays, std::span<std::uint8_t> is_hit, const HitFilter& filter) const {
    check_length("is_hit", is_hit.size(), rays.size());
    for_each_ray(state_->arena, rays.size(), [&](std::size_t i) { is_hit[i] = any(rays[i], filter) ? 1 : 0; });
}

HitLists Tracer::all(std::span<const Ray> rays) const {
    return with_memory_errors("the hits of the rays", [&] {
        // Each piece keeps its hits in a list of its own; then all go one behind the other.
        std::vector<std::vector<Hit>> lists(rays.size() / kRaysPerPiece + 1);
        HitLists result;
        result.begins.assign(rays.size() + 1, 0);
        for_each_piece(state_->arena, rays.size(), [&](std::size_t begin, std::size_t end) {
            std::vector<Hit> hits;
            std::vector<Hit>& list = lists[begin / kRaysPerPiece];
            for (std::size_t i = begin; i < end; ++i) {
                state_->all(rays[i], hits);
                result.begins[i + 1] = hits.size();
                list.insert(list.end(), hits.begin(), hits.end());
            }
        });
        for (std::size_t i = 0; i < rays.size(); ++i)
            result.begins[i + 1] += result.begins[i];
        result.hits.resize(result.begins.back());
        for_each_piece(state_->arena, rays.size(), [&](std::size_t begin, std::size_t) {
            std::ranges::copy(lists[begin / kRaysPerPiece], result.hits.data() + result.begins[begin]);
        });
        return result;
    });
}

const Wide8& Tracer::layout() const noexcept {
    return *state_->traced;
}

}  // namespace clbvh
