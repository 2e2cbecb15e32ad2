#include "device/build/root.hpp"

namespace clbvh::device {

ProgramSpec root_program(const BuildSettings& settings) {
    return {"root.cl", settings.stream_group_size, ""};
}

void launch_root(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers, BoxOrder box_order) {
    Kernel& write_root = launcher.session().kernel(root_program(settings), "write_root");
    const bool sorted = box_order == BoxOrder::morton;
    launcher.count_bytes(2 * 64);  // a sibling pair is read, the root's pair written
    launcher.launch(write_root, 1, buffers.root_reference, buffers.leaf_count, buffers.primitive_count,
                    sorted ? buffers.leaves : buffers.boxes, std::uint32_t{sorted}, buffers.primitive_ids,
                    buffers.nodes);
}

void launch_clear_unused(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers) {
    Kernel& clear_unused = launcher.session().kernel(root_program(settings), "clear_unused");
    launcher.launch(clear_unused, settings.groups_to_fill, buffers.leaf_count, buffers.primitive_count, buffers.nodes);
}

}  // namespace clbvh::device
