#include "clbvh/layout/padded_triangles.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "clbvh/io/scene.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("padded triangles hold the vertices of each primitive") {
    Mesh mesh = generate_scene("terrain", 5000);
    LayoutArray<PaddedTriangle> triangles;
    make_padded_triangles(mesh, triangles);
    REQUIRE(triangles.size() == mesh.triangles.size());
    std::size_t differences = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3& v = mesh.vertices[mesh.triangles[i][corner]];
            differences += triangles[i].vertices[corner] == std::array<float, 4>{v.x, v.y, v.z, 0.0f} ? 0 : 1;
        }
    }
    CHECK(differences == 0);
    mesh.triangles[77][1] = 1u << 30;
    expect_error(ErrorCode::invalid_input, {"triangle 77"}, [&] { make_padded_triangles(mesh, triangles); });
    CHECK(triangles.empty());
}
