#include "device/layout.hpp"

namespace clbvh::device {

void launch_layout(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   std::uint32_t leaf_count) {
    Kernel& write_root = launcher.session().kernel("layout.cl", "write_root", settings.stream_group_size, "");
    launcher.launch(write_root, 1, buffers.root_reference, leaf_count, buffers.leaves, buffers.nodes);
}

}  // namespace clbvh::device
