#include "device/layout.hpp"

namespace clbvh::device {

void launch_layout(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers, BoxOrder box_order) {
    Kernel& write_root = launcher.session().kernel("layout.cl", "write_root", settings.stream_group_size, "");
    const bool sorted = box_order == BoxOrder::morton;
    launcher.count_bytes(2 * 64);  // a sibling pair is read, the root's pair written
    launcher.launch(write_root, 1, buffers.root_reference, buffers.leaf_count, sorted ? buffers.leaves : buffers.boxes,
                    std::uint32_t{sorted}, buffers.primitive_ids, buffers.nodes);
}

}  // namespace clbvh::device
