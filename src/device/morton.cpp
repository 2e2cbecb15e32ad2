#include "device/morton.hpp"

namespace clbvh::device {

void launch_morton(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                   std::uint32_t primitive_count) {
    Session& session = launcher.session();
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return session.kernel("morton.cl", name, settings.stream_group_size, "");
    };
    // A box is read; a pair and both halves of the code are written.
    launcher.count_bytes((24 + 8 + 8) * std::uint64_t{primitive_count});
    const Pieces pieces = settings.stream_pieces(primitive_count);
    if (settings.morton_code == MortonCode::xyz) {
        launcher.launch(kernel("morton_xyz"), pieces.count, b.boxes, b.bounds, primitive_count, pieces.length,
                        b.pairs_a, b.code_low, b.code_high);
        return;
    }
    launcher.launch(kernel("morton_tables"), 1, b.bounds, b.morton_tables, b.morton_parameters);
    launcher.launch(kernel("morton_extended"), pieces.count, b.boxes, b.morton_tables, b.morton_parameters,
                    primitive_count, pieces.length, b.pairs_a, b.code_low, b.code_high);
}

}  // namespace clbvh::device
