#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "clbvh/io/scene.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

/// A COLLADA file with an L of six corners, far from the origin, at two nodes, and a line.
const std::string kCollada = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="l"><mesh>
<source id="p"><float_array id="a" count="18">10000 10000 0 10002 10000 0 10002 10001 0 10001 10001 0 10001 10002 0 10000 10002 0</float_array>
<technique_common><accessor source="#a" count="6" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>6</vcount><p>0 1 2 3 4 5</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">
<node id="one"><instance_geometry url="#l"/></node>
<node id="two"><translate>0 0 5</translate><instance_geometry url="#l"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

/// Whether the library was built without assimp; then it has to say so.
bool without_assimp() {
    const TempFolder folder;
    const std::string path = folder.write("scene.dae", kCollada);
    try {
        (void)load_scene(path);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) return false;
        WARN("built without assimp: " << error.what());
        return true;
    }
    return false;
}

}  // namespace

TEST_CASE("polygons that come through assimp are cut into triangles here") {
    if (without_assimp()) return;
    const TempFolder folder;
    LoadReport report;
    const Mesh mesh = load_scene(folder.write("scene.dae", kCollada), {{}, &report});
    CHECK(mesh.triangles.size() == 8);
    CHECK(report.instances == 2);
    CHECK(report.overlapping_fans == 0);
    double area = 0.0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        area += 0.5 * std::abs((double{b.x} - a.x) * (double{c.y} - a.y) - (double{b.y} - a.y) * (double{c.x} - a.x));
    }
    CHECK(area == 6.0);
}

TEST_CASE("a file that assimp cannot parse is reported with its reason") {
    if (without_assimp()) return;
    const TempFolder folder;
    const std::string broken = folder.write("broken.dae", "<COLLADA></WRONG>");
    expect_error(ErrorCode::io, {broken}, [&] { (void)load_scene(broken); });
}

TEST_CASE("a format that nobody knows is unsupported") {
    const TempFolder folder;
    for (const std::string name : {"notes.unheard-of", "noextension"}) {
        const std::string path = folder.write(name, "text");
        expect_error(ErrorCode::unsupported, {path}, [&] { (void)load_scene(path); });
    }
}
