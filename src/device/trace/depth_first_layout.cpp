#include "device/trace/depth_first_layout.hpp"

#include <bit>

#include "kernels/tree/tree_constants.h"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kDepthFirstAlignment = 64;
constexpr std::uint64_t kDepthFirstWord = sizeof(cl_uint);

kernels::DepthFirstPlace place_of(const DepthFirstParts& parts) {
    return {.header = parts.header.offset,
            .nodes = parts.nodes.offset,
            .primitive_ids = parts.primitive_ids.offset,
            .parents = parts.parents.offset,
            .below = parts.below.offset,
            .places = parts.places.offset,
            .next_places = parts.next_places.offset,
            .top = parts.top.offset};
}

}  // namespace

DepthFirstParts lay_out_depth_first(DepthFirstKind kind, std::uint32_t node_count, std::uint32_t reference_count,
                                    const Block& place) {
    const std::uint64_t node_words = kind == DepthFirstKind::pair ? kernels::PAIR_NODE_WORDS : kernels::SKIP_NODE_WORDS;
    const std::uint64_t pairs = (std::uint64_t{node_count} + 1) / 2;
    DepthFirstParts parts;
    ArrayLayout layout(place, kDepthFirstAlignment);
    parts.header = layout.take(kDepthFirstWord * kernels::LAYOUT_HEADER_WORDS);
    parts.nodes = layout.take(kDepthFirstWord * node_words * node_count);
    parts.primitive_ids = layout.take(kDepthFirstWord * reference_count);
    parts.parents = layout.take(kDepthFirstWord * pairs);
    parts.below = layout.take(kDepthFirstWord * kernels::SUBTREE_WORDS * pairs);
    parts.places = layout.take(kDepthFirstWord * kernels::PLACE_WORDS * pairs);
    parts.next_places = layout.take(kDepthFirstWord * kernels::PLACE_WORDS * pairs);
    parts.top = layout.take(kDepthFirstWord * pairs);
    parts.bytes = layout.bytes();
    return parts;
}

ProgramSpec depth_first_program(const LayoutSettings& settings) {
    return {"depth_first.cl", settings.work_group_size, ""};
}

void launch_depth_first(Launcher& launcher, const LayoutSettings& settings, DepthFirstKind kind,
                        const TraceScene& scene) {
    if (scene.reference_count == 0) return;
    const auto kernel = [&](const char* name) -> Kernel& {
        return launcher.session().kernel(depth_first_program(settings), name);
    };
    const kernels::ScenePlace place = place_of(scene);
    const kernels::DepthFirstPlace parts =
        place_of(lay_out_depth_first(kind, scene.node_count, scene.reference_count, scene.layout));
    const cl::Buffer& tree = scene.nodes.buffer;
    const cl::Buffer& out = scene.layout.buffer;
    const cl::Buffer& active_count = scene.active_count.is_there() ? scene.active_count.buffer : tree;
    const std::size_t groups =
        (std::size_t{scene.node_count} + kernels::SLOTS_PER_GROUP - 1) / kernels::SLOTS_PER_GROUP;
    const std::size_t top_groups = settings.share_groups;
    launcher.launch(kernel("link_pairs"), groups, tree, active_count, place, out, parts);
    launcher.launch(kernel("measure"), meeting_groups(settings.hand_over, groups), tree, active_count, place, out,
                    parts);
    launcher.launch(kernel("place_top"), top_groups, tree, place, out, parts);
    // The depth, which decides how many of these do anything, is below the number of pairs.
    const auto doublings = static_cast<std::uint32_t>(std::bit_width(scene.node_count / 2));
    for (std::uint32_t doubling = 0; doubling < doublings; ++doubling)
        launcher.launch(kernel("double_ways"), top_groups, tree, place, out, parts, doubling);
    launcher.launch(kernel("write_nodes"), top_groups, tree, scene.primitive_ids.buffer, place, out, parts,
                    std::uint32_t{kind == DepthFirstKind::pair});
}

}  // namespace clbvh::device
