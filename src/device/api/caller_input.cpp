#include "device/api/caller_input.hpp"

#include <string>
#include <utility>

#include "clbvh/core/error.hpp"
#include "clbvh/core/mesh.hpp"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kFloat = sizeof(float);

std::uint64_t used_bytes(std::uint64_t count, std::uint64_t stride, std::uint64_t last) {
    return count > 0 ? (count - 1) * stride + last : 0;
}

CallerInput check_form(const Session& session, const DeviceBoxes& input) {
    check_multiple("the boxes' offset", input.boxes.offset, 0, kFloat);
    check_multiple("the boxes' stride", input.stride, sizeof(Aabb), kFloat);
    CallerInput checked;
    checked.vertices = examine(session, "the boxes", input.boxes, used_bytes(input.count, input.stride, sizeof(Aabb)));
    checked.mesh.form = InputForm::boxes;
    checked.mesh.vertices = checked.vertices.given;
    checked.mesh.vertex_stride = input.stride;
    return checked;
}

CallerInput check_form(const Session& session, const DeviceTriangles& input) {
    check_multiple("the vertices' offset", input.vertices.offset, 0, kFloat);
    check_multiple("the vertices' stride", input.vertex_stride, sizeof(Vec3), kFloat);
    const bool is_indexed = input.indices.buffer != nullptr;
    const std::uint64_t least_vertices = is_indexed ? 1 : 3 * std::uint64_t{input.count};
    CallerInput checked;
    checked.vertices =
        examine(session, "the vertices", input.vertices, used_bytes(least_vertices, input.vertex_stride, sizeof(Vec3)));
    checked.mesh.vertices = checked.vertices.given;
    checked.mesh.vertex_stride = input.vertex_stride;
    if (!is_indexed) {
        checked.mesh.form = InputForm::triangles;
        return checked;
    }
    const bool is_short = input.index_type == IndexType::uint16;
    const std::uint64_t index_bytes = is_short ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
    const std::uint64_t stride = input.index_stride != 0 ? input.index_stride : 3 * index_bytes;
    check_multiple("the indices' offset", input.indices.offset, 0, index_bytes);
    check_multiple("the indices' stride", stride, 3 * index_bytes, index_bytes);
    checked.indices = examine(session, "the indices", input.indices, used_bytes(input.count, stride, 3 * index_bytes));
    checked.mesh.form = is_short ? InputForm::indexed_16 : InputForm::indexed_32;
    checked.mesh.indices = checked.indices.given;
    checked.mesh.index_stride = static_cast<std::uint32_t>(stride);
    return checked;
}

}  // namespace

CallerInput check_input(const Session& session, const DeviceInput& input) {
    CallerInput checked = std::visit([&](const auto& primitives) { return check_form(session, primitives); }, input);
    check_readable(checked.vertices);
    if (checked.indices.is_there()) check_readable(checked.indices);
    checked.mesh.primitive_count = checked.mesh.active_count = count_of(input);
    return checked;
}

std::uint32_t count_of(const DeviceInput& input) {
    return std::visit([](const auto& primitives) { return primitives.count; }, input);
}

void check_device_options(std::string_view who, const BuildOptions& options) {
    for (const auto& [name, is_given] : {std::pair{"max_leaf_size", options.max_leaf_size != 0},
                                         std::pair{"presplit_level", options.presplit_level != 0},
                                         std::pair{"split_quota", options.split_quota != 0.0f}}) {
        if (!is_given) continue;
        throw Error(ErrorCode::unsupported, std::string(name) + " asks for work of the host, which " +
                                                std::string(who) + " leaves out; use Builder, or leave it alone");
    }
}

}  // namespace clbvh::device
