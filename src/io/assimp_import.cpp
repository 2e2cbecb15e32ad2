#include "io/assimp_import.hpp"

#include <string>

#include "clbvh/core/error.hpp"

#ifdef CLBVH_HAS_ASSIMP
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
#endif

namespace clbvh::io {

#ifdef CLBVH_HAS_ASSIMP
namespace {

[[noreturn]] void fail_face(const std::filesystem::path& path, const aiMesh& part, unsigned face,
                            const std::string& what) {
    throw Error(ErrorCode::io,
                path.string() + ": mesh \"" + part.mName.C_Str() + "\", face " + std::to_string(face) + ": " + what);
}

/// assimp's post-processing follows indices blindly and aborts the process at an empty face, so both are refused first.
void check_faces(const aiMesh& part, const std::filesystem::path& path) {
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        const std::span corners(part.mFaces[i].mIndices, part.mFaces[i].mNumIndices);
        if (corners.empty()) fail_face(path, part, i, "no vertices");
        for (const unsigned corner : corners) {
            if (corner < part.mNumVertices) continue;
            fail_face(path, part, i,
                      "vertex " + std::to_string(corner) + " does not exist; the mesh has " +
                          std::to_string(part.mNumVertices));
        }
    }
}

void append_part(const aiMesh& part, const aiMatrix4x4& transform, const std::filesystem::path& path, Mesh& mesh) {
    if (mesh.vertices.size() + part.mNumVertices > std::numeric_limits<std::uint32_t>::max()) {
        throw Error(ErrorCode::unsupported, path.string() + ": more than 2^32 vertices; split the scene");
    }
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const aiVector3D& vertex : std::span(part.mVertices, part.mNumVertices)) {
        const aiVector3D placed = transform * vertex;
        mesh.vertices.push_back({placed.x, placed.y, placed.z});
    }
    for (const aiFace& face : std::span(part.mFaces, part.mNumFaces)) {
        if (face.mNumIndices != 3) continue;
        mesh.triangles.push_back({base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
    }
}

struct PlacedNode {
    const aiNode* node;
    aiMatrix4x4 transform;
};

Mesh flatten(const aiScene& scene, const std::filesystem::path& path) {
    Mesh mesh;
    std::vector<PlacedNode> open{{scene.mRootNode, scene.mRootNode->mTransformation}};
    while (!open.empty()) {
        const PlacedNode placed = open.back();
        open.pop_back();
        for (const unsigned part : std::span(placed.node->mMeshes, placed.node->mNumMeshes)) {
            append_part(*scene.mMeshes[part], placed.transform, path, mesh);
        }
        // Pushed last to first, so that the first child is next.
        for (unsigned i = placed.node->mNumChildren; i > 0; --i) {
            const aiNode* child = placed.node->mChildren[i - 1];
            open.push_back({child, placed.transform * child->mTransformation});
        }
    }
    return mesh;
}

}  // namespace

Mesh load_with_assimp(const std::filesystem::path& path) {
    Assimp::Importer importer;
    if (!importer.IsExtensionSupported(path.extension().string())) {
        throw Error(ErrorCode::unsupported, path.string() + ": unknown format \"" + path.extension().string() +
                                                "\"; OBJ, PLY, glTF, GLB, STL and others of assimp are read");
    }
    const aiScene* scene = importer.ReadFile(path.string(), 0);
    if (scene == nullptr) throw Error(ErrorCode::io, path.string() + ": " + importer.GetErrorString());
    for (const aiMesh* part : std::span(scene->mMeshes, scene->mNumMeshes))
        check_faces(*part, path);
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    if (scene == nullptr) throw Error(ErrorCode::io, path.string() + ": " + importer.GetErrorString());
    return flatten(*scene, path);
}

#else

Mesh load_with_assimp(const std::filesystem::path& path) {
    throw Error(ErrorCode::unsupported, path.string() + ": this build of the library reads OBJ and PLY; for other " +
                                            "formats install libassimp-dev, and configure and build it again");
}

#endif

}  // namespace clbvh::io
