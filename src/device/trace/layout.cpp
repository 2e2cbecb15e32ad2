#include "device/trace/layout.hpp"

#include <algorithm>
#include <tuple>

#include "kernels/layout/layout_constants.h"

namespace clbvh::device {
namespace {

constexpr std::uint32_t kLayoutGroupSize = 64;
constexpr std::uint32_t kRowsOfGroup = 1024;

// Places where a sibling pair, a line of 64 bytes, may begin.
constexpr std::uint64_t kLayoutAlignment = 64;
constexpr std::uint64_t kLayoutWord = sizeof(cl_uint);

// A wide node that is not full has leaves alone, of more than four primitives together. So there are most nodes where
// seven of eight are such, with five primitives each, and all children of the others are nodes: 8 for 35 primitives.
std::uint64_t most_nodes(std::uint64_t references) {
    return references * 8 / 35 + 2;
}

template <typename... Arguments>
void launch_in_layout(Launcher& launcher, const LayoutSettings& settings, const char* name, std::size_t groups,
                      const std::tuple<Arguments...>& arguments) {
    Kernel& kernel = launcher.session().kernel(layout_program(settings), name);
    std::apply([&](const auto&... values) { launcher.launch(kernel, groups, values...); }, arguments);
}

// OPENING_ARGUMENTS of kernels/layout/wide_layout.cl.
auto opening_arguments(const LayoutInput& scene, const SceneLayout& layout) {
    return std::make_tuple(scene.nodes.buffer, scene.nodes.offset, layout.state.buffer, layout.state.offset,
                           layout.pieces.offset, layout.next_chunks.offset, layout.records.offset, layout.header.buffer,
                           layout.header.offset);
}

// TREE_SIZE_ARGUMENTS of kernels/tree/tree_nodes.clh. No kernel is given a null buffer.
auto tree_size_arguments(const LayoutInput& scene) {
    const bool has_count = scene.active_count.is_there();
    return std::make_tuple(scene.node_count, has_count ? scene.active_count.buffer : scene.nodes.buffer,
                           scene.active_count.offset, std::uint32_t{has_count});
}

// TARGET_ARGUMENTS of kernels/layout/wide_layout.cl.
auto layout_target_arguments(const LayoutInput& scene, const SceneLayout& layout) {
    const DeviceMesh& mesh = scene.mesh;
    const cl::Buffer& indices = mesh.triangles() != nullptr ? mesh.triangles : mesh.vertices;
    return std::make_tuple(scene.primitive_ids.buffer, scene.primitive_ids.offset,
                           static_cast<std::uint32_t>(mesh.form), mesh.vertices, mesh.vertex_offset, mesh.vertex_stride,
                           indices, mesh.triangle_offset, mesh.triangle_stride, layout.nodes.offset,
                           layout.blocks.offset, layout.sources.offset);
}

void launch_rows(Launcher& launcher, const LayoutSettings& settings, const LayoutInput& scene,
                 const SceneLayout& layout) {
    const std::size_t groups = (std::size_t{scene.reference_count} + kRowsOfGroup - 1) / kRowsOfGroup;
    launch_in_layout(launcher, settings, "write_rows", groups,
                     std::tuple_cat(std::make_tuple(layout.header.buffer), layout_target_arguments(scene, layout),
                                    std::make_tuple(layout.rows.offset, scene.mesh.primitive_count,
                                                    scene.reference_count, kRowsOfGroup)));
}

}  // namespace

SceneLayout lay_out_scene(std::uint32_t node_count, std::uint32_t reference_count, const Block& place) {
    SceneLayout scene;
    const std::uint64_t nodes = most_nodes(reference_count);
    scene.most_pieces =
        std::min<std::uint32_t>(node_count / kernels::NODES_OF_PIECE, kernels::MOST_PIECES) + kernels::WIDE_WIDTH + 1;
    // Roots of pieces have a record there and one in the top; the last chunk of a piece may be nearly empty.
    const std::uint64_t records = nodes + scene.most_pieces;
    const std::uint64_t chunks = records / kernels::RECORDS_OF_CHUNK + scene.most_pieces + 1;
    ArrayLayout layout(place, kLayoutAlignment);
    scene.header = layout.take(kLayoutWord * kernels::LAYOUT_HEADER_WORDS);
    scene.nodes = layout.take(sizeof(float) * kernels::WIDE_NODE_FLOATS * nodes);
    scene.blocks = layout.take(sizeof(float) * kernels::BLOCK_FLOATS * reference_count);
    scene.sources = layout.take(kLayoutWord * kernels::WIDE_WIDTH * nodes);
    ArrayLayout scratch = layout;
    scene.rows = layout.take(sizeof(cl_float4) * kernels::LEAF_ROWS * reference_count);
    scene.state = scratch.take(kLayoutWord * kernels::OPENING_WORDS);
    scene.pieces = scratch.take(kLayoutWord * kernels::PIECE_WORDS * scene.most_pieces);
    scene.next_chunks = scratch.take(kLayoutWord * chunks);
    scene.records = scratch.take(kLayoutWord * kernels::RECORD_WORDS * kernels::RECORDS_OF_CHUNK * chunks);
    scene.bytes = std::max(layout.bytes(), scratch.bytes());
    return scene;
}

LayoutSettings resolve_layout_settings(Session& session, Shape shape) {
    const DeviceFit fit = fit_to_device(session, shape);
    const std::size_t largest = session.info().max_work_group_size;
    return {fit.lane() ? 1 : std::min<std::size_t>(kLayoutGroupSize, largest), fit.groups_to_fill * 4};
}

ProgramSpec layout_program(const LayoutSettings& settings) {
    return {"wide_layout.cl", settings.work_group_size, ""};
}

void launch_layout(Launcher& launcher, const LayoutSettings& settings, const LayoutInput& scene, const Block& place) {
    if (scene.reference_count == 0) return;
    const SceneLayout layout = lay_out_scene(scene.node_count, scene.reference_count, place);
    const auto opening = opening_arguments(scene, layout);
    launch_in_layout(launcher, settings, "open_top", 1, std::tuple_cat(opening, tree_size_arguments(scene)));
    launch_in_layout(launcher, settings, "open_pieces", layout.most_pieces - 1, opening);
    launch_in_layout(launcher, settings, "number_pieces", 1, opening);
    launch_in_layout(launcher, settings, "write_pieces", layout.most_pieces,
                     std::tuple_cat(opening, layout_target_arguments(scene, layout)));
    launch_rows(launcher, settings, scene, layout);
}

void launch_layout_refit(Launcher& launcher, const LayoutSettings& settings, const LayoutInput& scene,
                         const Block& place) {
    if (scene.reference_count == 0) return;
    const SceneLayout layout = lay_out_scene(scene.node_count, scene.reference_count, place);
    launch_in_layout(launcher, settings, "refit_layout", settings.refit_groups,
                     std::tuple_cat(std::make_tuple(scene.nodes.buffer, scene.nodes.offset, layout.header.buffer,
                                                    layout.header.offset),
                                    layout_target_arguments(scene, layout)));
    launch_rows(launcher, settings, scene, layout);
}

}  // namespace clbvh::device
