#include "support/found_rays.hpp"

#include "clbvh/trace/binary_tracer.hpp"
#include "clbvh/trace/tracer.hpp"
#include "support/oracle/ray_oracle.hpp"

namespace clbvh::test {
namespace {

std::size_t count_other_primitives(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    std::size_t differences = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        differences += a[i].primitive != b[i].primitive ? 1 : 0;
    return differences;
}

}  // namespace

DeviceTracerOptions tracer_options(Shape shape, TriangleTest test) {
    DeviceTracerOptions options;
    options.shape = shape;
    options.triangle_test = test;
    return options;
}

Found found_by_host(const Bvh& bvh, const Mesh& mesh, TriangleTest test, std::span<const Ray> rays) {
    const BinaryTracer tracer(bvh, mesh, {test});
    Found found(rays.size());
    tracer.closest(rays, found.hits, found.closest_counts);
    tracer.any(rays, found.is_hit, found.any_counts);
    return found;
}

Found found_by_device(DeviceTracer& tracer, std::span<const Ray> rays) {
    Found found(rays.size()), uncounted(rays.size());
    tracer.closest(rays, found.hits, found.closest_counts);
    tracer.any(rays, found.is_hit, found.any_counts);
    tracer.closest(rays, uncounted.hits);
    tracer.any(rays, uncounted.is_hit);
    if (!tracer.is_exact()) return found;
    CHECK(count_differences(uncounted.hits, found.hits) == 0);
    CHECK(count_differences(uncounted.is_hit, found.is_hit) == 0);
    return found;
}

void check_same(const Found& found, const Found& expected) {
    if (!DeviceTracer(shared_context()).is_exact()) {
        WARN("SKIPPED: the device does not round as the host does, so bits go unchecked");
        CHECK(count_other_primitives(found.hits, expected.hits) <= expected.hits.size() / 10);
        return;
    }
    CHECK(count_differences(found.hits, expected.hits) == 0);
    CHECK(count_differences(found.is_hit, expected.is_hit) == 0);
    CHECK(count_differences(found.closest_counts, expected.closest_counts) == 0);
    CHECK(count_differences(found.any_counts, expected.any_counts) == 0);
}

std::vector<Ray> rays_for(const Mesh& mesh, std::size_t each) {
    std::vector<Ray> rays = difficult_rays(mesh, each);
    const std::vector<Ray> untraceable = untraceable_rays();
    rays.insert(rays.end(), untraceable.begin(), untraceable.end());
    return rays;
}

}  // namespace clbvh::test
