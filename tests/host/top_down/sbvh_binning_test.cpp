// Spatial splits against brute force: every plane tried by clipping every triangle in double precision.
#include "host/top_down/sbvh_binning.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "clbvh/io/scene.hpp"
#include "support/references.hpp"

using namespace clbvh;
using namespace clbvh::host;
using namespace clbvh::test;

namespace {

struct DoubleBox {
    std::array<double, 3> lower{1e300, 1e300, 1e300};
    std::array<double, 3> upper{-1e300, -1e300, -1e300};

    void merge(const std::array<double, 3>& point) {
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], point[k]);
            upper[k] = std::max(upper[k], point[k]);
        }
    }
    [[nodiscard]] double half_area() const {
        const double x = upper[0] - lower[0];
        const double y = upper[1] - lower[1];
        const double z = upper[2] - lower[2];
        return x * (y + z) + y * z;
    }
};

std::array<double, 3> corner(const Mesh& mesh, std::size_t triangle, std::size_t i) {
    const Vec3& v = mesh.vertices[mesh.triangles[triangle][i]];
    return {v.x, v.y, v.z};
}

struct Plane {
    std::size_t axis;
    double position;
};

/// Grows `boxes` by the parts of a triangle to the left and to the right of the plane.
void add_parts(const Mesh& mesh, std::size_t triangle, const Plane& plane, std::array<DoubleBox, 2>& boxes) {
    for (std::size_t i = 0; i < 3; ++i) {
        const auto a = corner(mesh, triangle, i);
        const auto b = corner(mesh, triangle, (i + 1) % 3);
        const double from = a[plane.axis] - plane.position;
        const double to = b[plane.axis] - plane.position;
        if (from <= 0) boxes[0].merge(a);
        if (from >= 0) boxes[1].merge(a);
        if (from * to >= 0) continue;
        std::array<double, 3> crossing;
        for (std::size_t k = 0; k < 3; ++k)
            crossing[k] = a[k] + from / (from - to) * (b[k] - a[k]);
        boxes[0].merge(crossing);
        boxes[1].merge(crossing);
    }
}

struct Candidate {
    double cost = 1e300;
    std::uint32_t lefts = 0;
    std::uint32_t rights = 0;
};

Candidate try_plane(const Mesh& mesh, const Plane& plane) {
    Candidate candidate;
    std::array<DoubleBox, 2> boxes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Aabb box = triangle_bounds(mesh, i);
        const std::array<double, 3> lower{box.lower.x, box.lower.y, box.lower.z};
        const std::array<double, 3> upper{box.upper.x, box.upper.y, box.upper.z};
        if (lower[plane.axis] < plane.position) ++candidate.lefts;
        if (upper[plane.axis] >= plane.position) ++candidate.rights;
        add_parts(mesh, i, plane, boxes);
    }
    if (candidate.lefts > 0 && candidate.rights > 0) {
        candidate.cost = boxes[0].half_area() * candidate.lefts + boxes[1].half_area() * candidate.rights;
    }
    return candidate;
}

Box4 bounds_of(const std::vector<Reference>& references) {
    Box4 box;
    for (const Reference& reference : references)
        box.merge(Box4::of(reference));
    return box;
}

}  // namespace

TEST_CASE("the spatial split that is found costs what brute force says, and none costs less") {
    for (const char* scene : {"soup", "hair", "city", "clustered", "sphere"}) {
        for (const std::uint32_t count : {2u, 7u, 40u, 200u}) {
            for (const std::uint32_t bin_count : {2u, 16u, 64u}) {
                INFO(scene << ", " << count << " triangles, " << bin_count << " bins");
                const Mesh mesh = generate_scene(scene, count);
                const MeshView view = mesh;
                const std::vector<Reference> references = references_of(mesh);
                const SpatialBinning binning(bounds_of(references), bin_count);
                SpatialBinSet bins(bin_count);
                bins.add(&view, references, binning);
                const SpatialSplit split = bins.find_split(binning, 4 * count);
                Candidate best;
                for (std::uint32_t axis = 0; axis < 3; ++axis) {
                    for (std::uint32_t bin = 1; bin < bin_count && binning.divides(axis); ++bin) {
                        const Candidate candidate = try_plane(mesh, {axis, double{binning.plane(axis, bin)}});
                        if (candidate.cost < best.cost) best = candidate;
                        if (!split.found() || axis != split.axis || bin != split.bin) continue;
                        CHECK(candidate.lefts == split.left_count);
                        CHECK(candidate.rights == split.right_count);
                        CHECK(candidate.cost == Approx(double{split.cost}).epsilon(1e-4));
                    }
                }
                CHECK(split.found() == (best.cost < 1e300));
                CHECK(double{split.cost} <= best.cost * (1 + 1e-4));
            }
        }
    }
}

TEST_CASE("splits that need more references than there is room for are passed over") {
    const Mesh mesh = generate_scene("hair", 100);
    const MeshView view = mesh;
    const std::vector<Reference> references = references_of(mesh);
    const SpatialBinning binning(bounds_of(references), 16);
    SpatialBinSet bins(16);
    bins.add(&view, references, binning);
    float last_cost = 0.0f;
    for (std::uint32_t most = 200; most >= 100; most -= 10) {
        const SpatialSplit split = bins.find_split(binning, most);
        if (split.found()) CHECK(split.left_count + split.right_count <= most);
        CHECK(split.cost >= last_cost);
        last_cost = split.cost;
    }
    CHECK(last_cost > bins.find_split(binning, 200).cost);
}

TEST_CASE("bins of parts of the references add up to the bins of all") {
    const Mesh mesh = generate_scene("city", 500);
    const MeshView view = mesh;
    const std::vector<Reference> references = references_of(mesh);
    const SpatialBinning binning(bounds_of(references), 16);
    SpatialBinSet all(16), first(16), second(16);
    all.add(&view, references, binning);
    first.add(&view, std::span(references).first(200), binning);
    second.add(&view, std::span(references).subspan(200), binning);
    first.add(second);
    const SpatialSplit a = all.find_split(binning, 1000);
    const SpatialSplit b = first.find_split(binning, 1000);
    CHECK(a.found());
    CHECK(a.cost == b.cost);
    CHECK(a.axis == b.axis);
    CHECK(a.bin == b.bin);
}

TEST_CASE("boxes that are next to flat are not divided across") {
    const Reference flat{{0, 0, 5}, 0, {1, 1e-44f, 5}, 0};
    const SpatialBinning binning(Box4::of(flat), 16);
    CHECK(binning.divides(0));
    CHECK_FALSE(binning.divides(1));
    CHECK_FALSE(binning.divides(2));
}
