// A fuzzer for one reader of mesh files: CLBVH_FUZZ_READER is its function, such as read_obj. Whatever the bytes are,
// the reader makes a mesh whose indices are in range, or throws an Error.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "clbvh/core/error.hpp"
#include "io/read/gltf.hpp"
#include "io/read/mesh_sink.hpp"
#include "io/read/obj.hpp"
#include "io/read/off.hpp"
#include "io/read/ply.hpp"
#include "io/read/stl.hpp"

namespace {

/// Buffers of glTF files lie in a folder that is not there.
[[maybe_unused]] void read_gltf_alone(std::string_view text, clbvh::io::MeshSink& sink) {
    clbvh::io::read_gltf(text, "/nonexistent-folder-of-fuzz-reader", sink);
}

void check(const clbvh::Mesh& mesh) {
    for (const clbvh::Triangle& triangle : mesh.triangles) {
        for (const std::uint32_t index : triangle) {
            if (index >= mesh.vertices.size()) std::abort();
        }
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace clbvh::io;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    MeshSink sink("file", size, {});
    try {
        CLBVH_FUZZ_READER(text, sink);
    } catch (const clbvh::Error&) {
        return 0;
    }
    check(sink.mesh);
    return 0;
}
