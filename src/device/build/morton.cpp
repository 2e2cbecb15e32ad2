#include "device/build/morton.hpp"

#include "device/build/radix_sort.hpp"

namespace clbvh::device {
namespace {

// Launches `name`_grid or `name`_extended, whose output is `arguments`.
template <typename... Arguments>
void launch_codes(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b, const std::string& name,
                  const Pieces& pieces, std::uint32_t primitive_count, const Arguments&... arguments) {
    const auto kernel = [&](std::string_view kernel_name) -> Kernel& {
        return launcher.session().kernel(morton_program(settings), kernel_name);
    };
    if (settings.configs.device.morton_code != MortonCode::extended) {
        const auto is_cubic = static_cast<cl_uint>(settings.configs.device.morton_code == MortonCode::cubic);
        launcher.launch(kernel(name + "_grid"), pieces.count, b.boxes, b.bounds, is_cubic, primitive_count,
                        pieces.length, arguments...);
        return;
    }
    launcher.launch(kernel("morton_tables"), 1, b.bounds, b.morton_tables, b.morton_parameters);
    launcher.launch(kernel(name + "_extended"), pieces.count, b.boxes, b.morton_tables, b.morton_parameters,
                    primitive_count, pieces.length, arguments...);
}

}  // namespace

ProgramSpec morton_program(const BuildSettings& settings) {
    return {"morton.cl", settings.packed_keys() ? settings.sort_group_size : settings.stream_group_size, ""};
}

void launch_morton(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                   std::uint32_t primitive_count) {
    if (settings.packed_keys()) {
        const KeyLayout layout = settings.key_layout(primitive_count);
        launch_codes(launcher, settings, b, "packed", settings.sort_pieces(primitive_count), primitive_count,
                     layout.index_bits, layout.code_bits, unsorted_keys(settings, b, primitive_count), b.counts);
        launcher.count_bytes((24 + 8) * std::uint64_t{primitive_count});
    } else {
        launch_codes(launcher, settings, b, "morton", settings.stream_pieces(primitive_count), primitive_count,
                     b.pairs_a, b.code_low, b.code_high);
        launcher.count_bytes((24 + 8 + 8) * std::uint64_t{primitive_count});
    }
}

}  // namespace clbvh::device
