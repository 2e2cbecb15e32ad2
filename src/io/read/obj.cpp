#include "io/read/obj.hpp"

// The implementation of a header-only library must not meet the one of a program that links this library.
#define tinyobj clbvh_tinyobj  // NOLINT(readability-identifier-naming)
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "io/read/obj_scan.hpp"

namespace clbvh::io {
namespace {

/// Receives the faces as tinyobjloader parses them.
struct FaceCollector {
    MeshSink& sink;
    std::vector<std::uint32_t> corners = {};

    void add(const tinyobj::index_t* indices, int count) {
        corners.clear();
        for (int i = 0; i < count; ++i)
            corners.push_back(static_cast<std::uint32_t>(indices[i].vertex_index - 1));
        sink.tick_item();
        sink.add_face(corners);
    }
};

}  // namespace

// tinyobjloader's own triangulation is not used: it loses triangles of concave, and now and then of convex, polygons.
void read_obj(std::string_view text, MeshSink& sink) {
    std::istringstream faces(scan_obj(text, sink));
    FaceCollector collector{sink};
    tinyobj::callback_t callbacks;
    callbacks.index_cb = [](void* user, tinyobj::index_t* indices, int count) {
        static_cast<FaceCollector*>(user)->add(indices, count);
    };
    std::string error;
    if (!tinyobj::LoadObjWithCallback(faces, callbacks, &collector, nullptr, nullptr, &error)) sink.fail(error);
}

}  // namespace clbvh::io
