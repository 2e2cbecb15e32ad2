#include "device/build/leaves.hpp"

namespace clbvh::device {

ProgramSpec leaves_program(const BuildSettings& settings) {
    return {"leaves.cl", settings.stream_group_size, ""};
}

void launch_leaves(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                   std::uint32_t leaf_count) {
    Kernel& gather = launcher.session().kernel(leaves_program(settings), "gather_leaves");
    const Pieces pieces = settings.stream_pieces(leaf_count);
    launcher.launch(gather, pieces.count, buffers.boxes, buffers.primitive_ids, buffers.leaf_count, pieces.length,
                    buffers.leaves);
    launcher.count_bytes((4 + 24 + 24) * std::uint64_t{leaf_count});
}

void launch_number_leaves(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
                          std::uint32_t leaf_count) {
    Kernel& number = launcher.session().kernel(leaves_program(settings), "number_leaves");
    const Pieces pieces = settings.stream_pieces(leaf_count);
    launcher.launch(number, pieces.count, buffers.leaf_count, pieces.length, buffers.references_a);
    launcher.count_bytes(4 * std::uint64_t{leaf_count});
}

}  // namespace clbvh::device
