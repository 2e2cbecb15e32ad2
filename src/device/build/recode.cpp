#include "device/build/recode.hpp"

namespace clbvh::device {

ProgramSpec recode_program(const BuildSettings& settings) {
    return {"recode.cl", settings.sort_group_size, ""};
}

void launch_recode(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                   std::uint32_t primitive_count) {
    if (primitive_count <= kernels::LONGEST_RUN) return;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return launcher.session().kernel(recode_program(settings), name);
    };
    const std::uint32_t index_bits = settings.key_layout(primitive_count).index_bits;
    const Pieces pieces = settings.sort_pieces(primitive_count);
    // At least: where there are runs, their boxes and keys, too.
    launcher.count_bytes(8 * std::uint64_t{primitive_count});
    if (pieces.count == 1) {
        launcher.launch(kernel("recode_at_once"), 1, b.boxes, b.primitive_count, index_bits, b.recode_state,
                        b.recode_runs, b.codes, b.primitive_ids, b.keys);
        return;
    }
    launcher.launch(kernel("clear_state"), 1, b.recode_state);
    for (cl_uint round = 0; round < kernels::RECODE_ROUNDS; ++round) {
        launcher.launch(kernel("find_runs"), pieces.count, b.codes, b.primitive_count, pieces.length, index_bits, round,
                        b.recode_state, b.recode_runs);
        launcher.launch(kernel("find_levels"), pieces.count, b.codes, b.primitive_count, pieces.length, index_bits,
                        round, b.recode_state);
        launcher.launch(kernel("pack_codes"), pieces.count, b.codes, b.primitive_count, pieces.length, index_bits,
                        round, b.recode_state);
        launcher.launch(kernel("recode_runs"), pieces.count, b.boxes, index_bits, round, b.recode_state, b.recode_runs,
                        b.codes, b.primitive_ids, b.keys);
    }
}

}  // namespace clbvh::device
