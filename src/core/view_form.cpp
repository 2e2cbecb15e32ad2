#include "core/view_form.hpp"

#include <cstddef>
#include <cstdint>
#include <string>

#include "clbvh/core/error.hpp"

namespace clbvh {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_input, what);
}

void check_pointer(const std::string& name, const void* pointer, std::uint64_t count, std::size_t alignment) {
    if (pointer == nullptr && count > 0)
        refuse(name + " are at a null pointer, but there are " + std::to_string(count));
    if (reinterpret_cast<std::uintptr_t>(pointer) % alignment == 0) return;
    refuse(name + " do not begin at a multiple of " + std::to_string(alignment) +
           " bytes, which reading them needs: copy them to where they do");
}

void check_stride(const std::string& name, std::uint64_t stride, std::size_t least, std::size_t unit) {
    if (stride >= least && stride % unit == 0) return;
    refuse("the stride of " + name + " is " + std::to_string(stride) + " bytes; it must be a multiple of " +
           std::to_string(unit) + " and at least " + std::to_string(least));
}

}  // namespace

void check_form(const MeshView& mesh) {
    check_pointer("the vertices", mesh.vertices, mesh.vertex_count, sizeof(float));
    check_stride("the vertices", mesh.vertex_stride, 3 * sizeof(float), sizeof(float));
    if (mesh.indices != nullptr) {
        const std::size_t bytes = mesh.index_type == IndexType::uint32 ? sizeof(std::uint32_t) : sizeof(std::uint16_t);
        check_pointer("the indices", mesh.indices, 3 * mesh.triangle_count, bytes);
        check_stride("the indices", mesh.bytes_between_triangles(), 3 * bytes, bytes);
    } else if (mesh.vertex_count / 3 < mesh.triangle_count) {
        refuse(std::to_string(mesh.vertex_count) + " vertices are too few for " + std::to_string(mesh.triangle_count) +
               " triangles without indices, which have three each");
    }
}

void check_form(const BoxView& boxes) {
    check_pointer("the boxes", boxes.boxes, boxes.count, sizeof(float));
    check_stride("the boxes", boxes.stride, sizeof(Aabb), sizeof(float));
}

}  // namespace clbvh
