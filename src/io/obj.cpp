#include "io/obj.hpp"

// The implementation of a header-only library must not meet the one of a program that links this library.
#define tinyobj clbvh_tinyobj  // NOLINT(readability-identifier-naming)
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "clbvh/core/error.hpp"
#include "io/input_file.hpp"
#include "io/obj_scan.hpp"
#include "io/polygon.hpp"

namespace clbvh::io {
namespace {

/// Receives the lines as tinyobjloader parses them. All vertices are known before; only relative indices need to know
/// how many came so far.
struct FaceCollector {
    Mesh& mesh;
    std::size_t vertices_so_far = 0;
    std::vector<std::uint32_t> corners = {};

    void add(const tinyobj::index_t* indices, int count) {
        corners.clear();
        for (int i = 0; i < count; ++i) {
            const std::int64_t index = indices[i].vertex_index;
            const std::int64_t base = index > 0 ? -1 : static_cast<std::int64_t>(vertices_so_far);
            corners.push_back(static_cast<std::uint32_t>(base + index));
        }
        append_polygon(corners, mesh);
    }
};

}  // namespace

// tinyobjloader's own triangulation is not used: it loses triangles of concave, and now and then of convex, polygons.
Mesh load_obj(const std::filesystem::path& path) {
    std::string text = read_whole_file(path);
    Mesh mesh;
    mesh.vertices = scan_obj(text, path);

    FaceCollector collector{mesh};
    tinyobj::callback_t callbacks;
    callbacks.vertex_cb = [](void* user, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t) {
        ++static_cast<FaceCollector*>(user)->vertices_so_far;
    };
    callbacks.index_cb = [](void* user, tinyobj::index_t* indices, int count) {
        static_cast<FaceCollector*>(user)->add(indices, count);
    };
    std::istringstream lines(std::move(text));
    std::string error;
    if (!tinyobj::LoadObjWithCallback(lines, callbacks, &collector, nullptr, nullptr, &error)) {
        throw Error(ErrorCode::io, path.string() + ": " + error);
    }
    return mesh;
}

}  // namespace clbvh::io
