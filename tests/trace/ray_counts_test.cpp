// Cost of rays: against a recursive second implementation, and against the SAH, which predicts it.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "clbvh/trace/binary_tracer.hpp"
#include "core/random.hpp"
#include "support/oracle/ray_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr float kSlack = 1.0f + 1.0f / 262144;

/// The traversal as its definition has it, recursive and without vectors.
class CountOracle {
public:
    CountOracle(const Bvh& bvh, const Mesh& mesh, const Ray& ray) : bvh_(bvh), mesh_(mesh), ray_(ray) {}

    enum class Goal { closest, any, visits };

    RayCounts run(Goal goal) {
        goal_ = goal;
        if (!bvh_.empty() && meets(bvh_.nodes[0])) enter(bvh_.nodes[0]);
        return counts_;
    }
    [[nodiscard]] const Hit& hit() const { return hit_; }

private:
    [[nodiscard]] float end() const { return goal_ == Goal::visits ? ray_.t_max : std::min(ray_.t_max, hit_.t); }

    [[nodiscard]] std::array<float, 2> range(const Node& node) const {
        const std::array<float, 3> o = {ray_.origin.x, ray_.origin.y, ray_.origin.z};
        const std::array<float, 3> d = {ray_.direction.x, ray_.direction.y, ray_.direction.z};
        float entry = std::max(ray_.t_min, 0.0f), exit = end();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float inverse = 1.0f / d[axis];
            float first = (node.lower[axis] - o[axis]) * inverse, last = (node.upper[axis] - o[axis]) * inverse;
            if (std::signbit(d[axis])) std::swap(first, last);
            if (first > entry) entry = first;
            if (last < exit) exit = last;
        }
        return {entry, exit};
    }
    [[nodiscard]] bool meets(const Node& node) const {
        const auto [entry, exit] = range(node);
        return entry <= exit * kSlack;
    }

    void enter(const Node& node) {
        if (node.is_leaf()) return enter_leaf(node);
        ++counts_.inner_nodes;
        const Node* near = &bvh_.nodes[node.first];
        const Node* far = near + 1;
        if (range(*far)[0] < range(*near)[0]) std::swap(near, far);
        const bool meets_near = meets(*near), meets_far = meets(*far);
        const float far_entry = range(*far)[0];
        if (meets_near) enter(*near);
        if (!is_done_ && meets_far && far_entry <= end() * kSlack) enter(*far);
    }

    void enter_leaf(const Node& node) {
        ++counts_.leaves;
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            ++counts_.triangles;
            if (goal_ == Goal::visits) continue;
            const std::uint32_t primitive = bvh_.primitive_ids[i];
            Hit hit = brute_force_closest({mesh_.vertices, {mesh_.triangles[primitive]}}, ray_);
            if (!hit) continue;
            is_done_ = goal_ == Goal::any;
            if (is_done_) return;
            hit.primitive = primitive;
            if (hit.t < hit_.t || (hit.t == hit_.t && primitive < hit_.primitive)) hit_ = hit;
        }
    }

    const Bvh& bvh_;
    const Mesh& mesh_;
    Ray ray_;
    Goal goal_ = Goal::closest;
    RayCounts counts_;
    Hit hit_;
    bool is_done_ = false;
};

/// A line through the box: a uniform point of its surface, and a direction into it by Lambert's law. Such lines meet
/// every convex body in the box as often as its area says.
Ray random_line(const Aabb& box, Random& random) {
    const std::array<float, 3> lower = {box.lower.x, box.lower.y, box.lower.z};
    const std::array<float, 3> extent = {box.upper.x - box.lower.x, box.upper.y - box.lower.y,
                                         box.upper.z - box.lower.z};
    const std::array<float, 3> areas = {extent[1] * extent[2], extent[2] * extent[0], extent[0] * extent[1]};
    float choice = random.unit() * (areas[0] + areas[1] + areas[2]);
    std::size_t axis = 0;
    while (axis < 2 && choice >= areas[axis])
        choice -= areas[axis++];
    const bool is_upper = random.below(2) == 1;
    const float angle = 6.2831853f * random.unit(), sine2 = random.unit();
    std::array<float, 3> o{}, d{};
    for (std::size_t i = 0; i < 3; ++i)
        o[i] = lower[i] + extent[i] * (i == axis ? (is_upper ? 1.0f : 0.0f) : random.unit());
    d[axis] = std::sqrt(1.0f - sine2) * (is_upper ? -1.0f : 1.0f);
    d[(axis + 1) % 3] = std::sqrt(sine2) * std::cos(angle);
    d[(axis + 2) % 3] = std::sqrt(sine2) * std::sin(angle);
    return {{o[0], o[1], o[2]}, 0.0f, {d[0], d[1], d[2]}};
}

}  // namespace

TEST_CASE("counts are those of the traversal's definition") {
    for (const char* scene : {"soup", "city", "hair", "clustered"}) {
        const Mesh mesh = generate_scene(scene, 600);
        for (const char* id : {"binned-sah", "sbvh", "locally-ordered"}) {
            BuildOptions options;
            options.max_leaf_size = id == std::string_view("binned-sah") ? 8 : 1;
            const Bvh bvh = build(mesh, id, options);
            const BinaryTracer tracer(bvh, mesh);
            std::size_t differences = 0;
            for (const Ray& ray : difficult_rays(mesh, 30)) {
                CountOracle closest(bvh, mesh, ray), any(bvh, mesh, ray), visits(bvh, mesh, ray);
                RayCounts closest_counts, any_counts;
                const Hit hit = tracer.closest(ray, closest_counts);
                static_cast<void>(tracer.any(ray, any_counts));
                if (closest.run(CountOracle::Goal::closest) != closest_counts) ++differences;
                if (!same_bits(closest.hit(), hit)) ++differences;
                if (any.run(CountOracle::Goal::any) != any_counts) ++differences;
                if (visits.run(CountOracle::Goal::visits) != tracer.visits(ray)) ++differences;
            }
            INFO(scene << ' ' << id);
            CHECK(differences == 0);
        }
    }
}

TEST_CASE("counts are added to what there was") {
    const Mesh mesh = generate_scene("soup", 600);
    const BinaryTracer tracer(build(mesh, "median"), mesh);
    const Ray ray = difficult_rays(mesh, 1)[0];
    RayCounts once, twice;
    static_cast<void>(tracer.closest(ray, once));
    for (int i = 0; i < 2; ++i)
        static_cast<void>(tracer.closest(ray, twice));
    CHECK(once.inner_nodes > 0);
    CHECK(twice == RayCounts{2 * once.inner_nodes, 2 * once.leaves, 2 * once.triangles});
}

TEST_CASE("random lines cost what the SAH predicts") {
    constexpr int lines = 40000;
    for (const char* scene : {"soup", "city", "terrain", "hair"}) {
        const Mesh mesh = generate_scene(scene, 5000);
        for (const char* id : {"binned-sah", "median"}) {
            BuildOptions options;
            options.max_leaf_size = 4;
            const Bvh bvh = build(mesh, id, options);
            const BinaryTracer tracer(bvh, mesh);
            Random random(11);
            // The first is the number of inner nodes, the second that of triangles.
            std::array<double, 2> sum{}, sum_of_squares{};
            for (int i = 0; i < lines; ++i) {
                const RayCounts counts = tracer.visits(random_line(bvh.nodes[0].bounds(), random));
                const std::array<double, 2> sample = {static_cast<double>(counts.inner_nodes),
                                                      static_cast<double>(counts.triangles)};
                for (std::size_t k = 0; k < 2; ++k) {
                    sum[k] += sample[k];
                    sum_of_squares[k] += sample[k] * sample[k];
                }
            }
            const std::array<double, 2> expected = {sah_cost(bvh, {1.0, 0.0}), sah_cost(bvh, {0.0, 1.0})};
            for (std::size_t k = 0; k < 2; ++k) {
                const double mean = sum[k] / lines;
                const double error = std::sqrt((sum_of_squares[k] / lines - mean * mean) / lines);
                INFO(scene << ' ' << id << ": " << mean << " +- " << error << ", SAH " << expected[k]);
                CHECK(std::abs(mean - expected[k]) < 4.0 * error);
                CHECK(error < 0.02 * mean);
            }
        }
    }
}
