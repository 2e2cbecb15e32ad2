#include "device/trace/layout.hpp"

#include <algorithm>

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

Kernel& layout_kernel(Launcher& launcher, const LayoutSettings& settings, const char* name) {
    return launcher.session().kernel(layout_program(settings), name);
}

void launch_rows(Launcher& launcher, const LayoutSettings& settings, const TraceScene& scene,
                 const SceneLayout& layout) {
    const std::size_t groups = (std::size_t{scene.reference_count} + kRowsOfGroup - 1) / kRowsOfGroup;
    launcher.launch(layout_kernel(launcher, settings, "write_rows"), groups, scene.primitive_ids.buffer,
                    scene.mesh.vertices.buffer, scene.mesh.index_buffer(), place_of(scene), scene.layout.buffer,
                    place_of(layout), scene.mesh.primitive_count, scene.reference_count, kRowsOfGroup);
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

kernels::ScenePlace place_of(const TraceScene& scene) {
    const DeviceMesh& mesh = scene.mesh;
    return {.nodes = scene.nodes.offset,
            .primitive_ids = scene.primitive_ids.offset,
            .vertices = mesh.vertices.offset,
            .indices = mesh.indices.offset,
            .active_count = scene.active_count.offset,
            .node_count = scene.node_count,
            .has_active_count = scene.active_count.is_there() ? 1u : 0u,
            .form = static_cast<std::uint32_t>(mesh.form),
            .vertex_stride = mesh.vertex_stride,
            .index_stride = mesh.index_stride,
            .unused = 0};
}

kernels::LayoutPlace place_of(const SceneLayout& layout) {
    return {.header = layout.header.offset,
            .nodes = layout.nodes.offset,
            .blocks = layout.blocks.offset,
            .sources = layout.sources.offset,
            .rows = layout.rows.offset,
            .state = layout.state.offset,
            .pieces = layout.pieces.offset,
            .next_chunks = layout.next_chunks.offset,
            .records = layout.records.offset};
}

LayoutSettings resolve_layout_settings(Session& session, Shape shape) {
    const DeviceFit fit = fit_to_device(session, shape);
    const std::size_t largest = session.info().max_work_group_size;
    return {fit.lane() ? 1 : std::min<std::size_t>(kLayoutGroupSize, largest), fit.groups_to_fill * 4};
}

ProgramSpec layout_program(const LayoutSettings& settings) {
    return {"wide_layout.cl", settings.work_group_size, ""};
}

void launch_layout(Launcher& launcher, const LayoutSettings& settings, const TraceScene& scene) {
    if (scene.reference_count == 0) return;
    const SceneLayout layout = lay_out_scene(scene.node_count, scene.reference_count, scene.layout);
    const auto kernel = [&](const char* name) -> Kernel& { return layout_kernel(launcher, settings, name); };
    const kernels::ScenePlace place = place_of(scene);
    const kernels::LayoutPlace parts = place_of(layout);
    const cl::Buffer& tree = scene.nodes.buffer;
    const cl::Buffer& out = scene.layout.buffer;
    const cl::Buffer& active_count = scene.active_count.is_there() ? scene.active_count.buffer : tree;
    launcher.launch(kernel("open_top"), 1, tree, active_count, place, out, parts);
    launcher.launch(kernel("open_pieces"), layout.most_pieces - 1, tree, place, out, parts);
    launcher.launch(kernel("number_pieces"), 1, tree, place, out, parts);
    launcher.launch(kernel("write_pieces"), layout.most_pieces, tree, scene.primitive_ids.buffer,
                    scene.mesh.vertices.buffer, scene.mesh.index_buffer(), place, out, parts);
    launch_rows(launcher, settings, scene, layout);
}

void launch_layout_refit(Launcher& launcher, const LayoutSettings& settings, const TraceScene& scene) {
    if (scene.reference_count == 0) return;
    const SceneLayout layout = lay_out_scene(scene.node_count, scene.reference_count, scene.layout);
    launcher.launch(layout_kernel(launcher, settings, "refit_layout"), settings.share_groups, scene.nodes.buffer,
                    scene.primitive_ids.buffer, scene.mesh.vertices.buffer, scene.mesh.index_buffer(), place_of(scene),
                    scene.layout.buffer, place_of(layout));
    launch_rows(launcher, settings, scene, layout);
}

}  // namespace clbvh::device
