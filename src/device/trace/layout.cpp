#include "device/trace/layout.hpp"

#include <algorithm>
#include <string>
#include <string_view>

namespace clbvh::device {
namespace {

constexpr std::uint32_t kLayoutGroupSize = 64;
constexpr std::uint32_t kRowsOfGroup = 1024;

// Places where a sibling pair, a line of 64 bytes, may begin.
constexpr std::uint64_t kLayoutAlignment = 64;
constexpr std::uint64_t kLayoutWord = sizeof(cl_uint);

// What a kind's kernels are compiled for, and how much room it takes: at most `nodes` for `references`.
struct WideForm {
    std::string_view file, options;
    std::uint32_t width;
    std::uint64_t node_bytes, element_bytes;
    std::uint64_t nodes, references;
};

// A node that is not full has leaves alone, of more primitives together than are joined to one leaf: of five or more,
// of a Compressed8 four or more. So there are most nodes of eight where seven of eight nodes are such, and all children
// of the others are nodes; and most nodes of four in a chain, where one has three leaves of one primitive beside the
// next node. Parts of large leaves take fewer nodes.
constexpr WideForm kWide8 = {"wide_layout.cl", "", 8, 224, 160, 8, 35};
constexpr WideForm kWide4 = {"wide_layout.cl", " -D WIDE_WIDTH=4", 4, 112, 160, 1, 3};
constexpr WideForm kCompressed8 = {"compressed8_layout.cl", "", 8, kernels::COMPRESSED_NODE_BYTES, 48, 2, 7};
static_assert(kWide8.node_bytes == sizeof(float) * WIDE_NODE_FLOATS_OF(8));
static_assert(kWide4.node_bytes == sizeof(float) * WIDE_NODE_FLOATS_OF(4));

constexpr const WideForm& form_of(WideKind kind) {
    switch (kind) {
        case WideKind::wide4: return kWide4;
        case WideKind::compressed8: return kCompressed8;
        case WideKind::wide8: break;
    }
    return kWide8;
}

Kernel& wide_kernel(Launcher& launcher, const LayoutSettings& settings, WideKind kind, const char* name) {
    return launcher.session().kernel(wide_program(settings, kind), name);
}

// Of wide8.
void launch_rows(Launcher& launcher, const LayoutSettings& settings, const TraceScene& scene, const WideParts& layout) {
    const std::size_t groups = (std::size_t{scene.reference_count} + kRowsOfGroup - 1) / kRowsOfGroup;
    launcher.launch(wide_kernel(launcher, settings, WideKind::wide8, "write_rows"), groups, scene.primitive_ids.buffer,
                    scene.mesh.vertices.buffer, scene.mesh.index_buffer(), place_of(scene), scene.layout.buffer,
                    place_of(layout), scene.mesh.primitive_count, scene.reference_count, kRowsOfGroup);
}

}  // namespace

WideParts lay_out_wide(WideKind kind, std::uint32_t node_count, std::uint32_t reference_count, const Block& place) {
    const WideForm& form = form_of(kind);
    WideParts parts;
    const std::uint64_t nodes = reference_count * form.nodes / form.references + 2;
    parts.most_pieces =
        std::min<std::uint32_t>(node_count / kernels::NODES_OF_PIECE, kernels::MOST_PIECES) + form.width + 1;
    // Roots of pieces have a record there and one in the top; the last chunk of a piece may be nearly empty.
    const std::uint64_t records = nodes + parts.most_pieces;
    const std::uint64_t chunks = records / kernels::RECORDS_OF_CHUNK + parts.most_pieces + 1;
    ArrayLayout layout(place, kLayoutAlignment);
    parts.header = layout.take(kLayoutWord * kernels::LAYOUT_HEADER_WORDS);
    parts.nodes = layout.take(form.node_bytes * nodes);
    parts.blocks = layout.take(form.element_bytes * reference_count);
    const bool is_traced = kind == WideKind::wide8;
    if (is_traced) parts.sources = layout.take(kLayoutWord * form.width * nodes);
    ArrayLayout scratch = layout;
    if (is_traced) parts.rows = layout.take(sizeof(cl_float4) * kernels::LEAF_ROWS * reference_count);
    parts.state = scratch.take(kLayoutWord * kernels::OPENING_WORDS);
    parts.pieces = scratch.take(kLayoutWord * kernels::PIECE_WORDS * parts.most_pieces);
    parts.next_chunks = scratch.take(kLayoutWord * chunks);
    parts.records = scratch.take(kLayoutWord * RECORD_WORDS_OF(form.width) * kernels::RECORDS_OF_CHUNK * chunks);
    parts.bytes = std::max(layout.bytes(), scratch.bytes());
    return parts;
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

kernels::LayoutPlace place_of(const WideParts& layout) {
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
    return {fit.lane() ? 1 : std::min<std::size_t>(kLayoutGroupSize, largest), fit.groups_to_fill * 4,
            session.hand_over()};
}

ProgramSpec wide_program(const LayoutSettings& settings, WideKind kind) {
    const WideForm& form = form_of(kind);
    return {form.file, settings.work_group_size, std::string(form.options)};
}

void launch_wide(Launcher& launcher, const LayoutSettings& settings, WideKind kind, const TraceScene& scene) {
    if (scene.reference_count == 0) return;
    const WideParts layout = lay_out_wide(kind, scene.node_count, scene.reference_count, scene.layout);
    const auto kernel = [&](const char* name) -> Kernel& { return wide_kernel(launcher, settings, kind, name); };
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
    if (kind == WideKind::wide8) launch_rows(launcher, settings, scene, layout);
}

void launch_wide_refit(Launcher& launcher, const LayoutSettings& settings, const TraceScene& scene) {
    if (scene.reference_count == 0) return;
    const WideParts layout = lay_out_wide(WideKind::wide8, scene.node_count, scene.reference_count, scene.layout);
    launcher.launch(wide_kernel(launcher, settings, WideKind::wide8, "refit_layout"), settings.share_groups,
                    scene.nodes.buffer, scene.primitive_ids.buffer, scene.mesh.vertices.buffer,
                    scene.mesh.index_buffer(), place_of(scene), scene.layout.buffer, place_of(layout));
    launch_rows(launcher, settings, scene, layout);
}

}  // namespace clbvh::device
