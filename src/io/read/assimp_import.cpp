#include "io/read/assimp_import.hpp"

#include <string>

#include "clbvh/core/error.hpp"

#ifdef CLBVH_HAS_ASSIMP
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cstdint>
#include <span>
#include <vector>
#endif

namespace clbvh::io {

#ifdef CLBVH_HAS_ASSIMP
namespace {

/// assimp's own triangulation is not used: it follows indices blindly, and loses parts of concave polygons.
void append_part(const aiMesh& part, const aiMatrix4x4& transform, MeshSink& sink) {
    sink.require_room(part.mNumVertices, part.mNumFaces);
    const auto base = static_cast<std::uint32_t>(sink.mesh.vertices.size());
    for (const aiVector3D& vertex : std::span(part.mVertices, part.mNumVertices)) {
        const aiVector3D placed = transform * vertex;
        sink.add_vertex({placed.x, placed.y, placed.z});
    }
    ++sink.report.instances;
    std::vector<std::uint32_t> corners;
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        sink.tick_item();
        corners.clear();
        for (const unsigned corner : std::span(part.mFaces[i].mIndices, part.mFaces[i].mNumIndices)) {
            if (corner >= part.mNumVertices) {
                sink.fail("mesh \"" + std::string(part.mName.C_Str()) + "\", face " + std::to_string(i) + ": vertex " +
                          std::to_string(corner) + " does not exist; the mesh has " +
                          std::to_string(part.mNumVertices));
            }
            corners.push_back(base + corner);
        }
        if (corners.size() == 1 || corners.size() == 2) {
            ++sink.report.points_and_lines;
        } else {
            sink.add_face(corners);
        }
    }
}

struct PlacedNode {
    const aiNode* node;
    aiMatrix4x4 transform;
};

void flatten(const aiScene& scene, MeshSink& sink) {
    sink.report.meshes = scene.mNumMeshes;
    sink.report.instances = 0;
    std::vector<PlacedNode> open{{scene.mRootNode, scene.mRootNode->mTransformation}};
    while (!open.empty()) {
        const PlacedNode placed = open.back();
        open.pop_back();
        for (const unsigned part : std::span(placed.node->mMeshes, placed.node->mNumMeshes)) {
            append_part(*scene.mMeshes[part], placed.transform, sink);
        }
        // Pushed last to first, so that the first child is next.
        for (unsigned i = placed.node->mNumChildren; i > 0; --i) {
            const aiNode* child = placed.node->mChildren[i - 1];
            open.push_back({child, placed.transform * child->mTransformation});
        }
    }
}

}  // namespace

void read_with_assimp(const std::filesystem::path& path, MeshSink& sink) {
    Assimp::Importer importer;
    if (!importer.IsExtensionSupported(path.extension().string())) {
        throw Error(ErrorCode::unsupported, path.string() + ": unknown format \"" + path.extension().string() +
                                                "\"; OBJ, PLY, STL, OFF, glTF and GLB are read, and others of assimp");
    }
    const aiScene* scene = importer.ReadFile(path.string(), 0);
    if (scene == nullptr) sink.fail(importer.GetErrorString());
    flatten(*scene, sink);
}

#else

void read_with_assimp(const std::filesystem::path& path, MeshSink&) {
    throw Error(ErrorCode::unsupported,
                path.string() + ": this build of the library reads OBJ, PLY, STL, OFF, glTF and " +
                    "GLB; for other formats install libassimp-dev, and configure and build it " + "again");
}

#endif

}  // namespace clbvh::io
