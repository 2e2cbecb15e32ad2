#include "device/radix_sort.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint32_t kRadix = 256;
constexpr std::uint32_t kDigitBits = 8;
constexpr std::uint32_t kPassesPerBlock = 4;
constexpr std::uint32_t kTile = 1024;

}  // namespace

void launch_radix_sort(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                       std::uint32_t primitive_count) {
    Session& session = launcher.session();
    const bool lane = settings.sort_shape == Shape::lane;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return session.kernel("radix_sort.cl", name, settings.sort_group_size, "");
    };
    Kernel& count = kernel("count_digits");
    const Pieces pieces = cut_into_pieces(primitive_count, settings.most_sort_pieces, lane ? 1 : kTile);
    const cl::Buffer* from = &b.pairs_a;
    const cl::Buffer* to = &b.pairs_b;
    for (std::uint32_t pass = 0; pass < 2 * kPassesPerBlock; ++pass) {
        const std::uint32_t shift = pass % kPassesPerBlock * kDigitBits;
        launcher.launch(count, pieces.count, *from, primitive_count, pieces.length, shift, b.counts);
        if (!lane) {
            launcher.launch(kernel("scan_counts"), 1, b.counts, kRadix * pieces.count);
        }
        if (pass == kPassesPerBlock - 1) {
            launcher.launch(kernel("scatter_rekey"), pieces.count, *from, primitive_count, pieces.length, shift,
                            b.counts, *to, b.code_high);
        } else if (pass == 2 * kPassesPerBlock - 1) {
            launcher.launch(kernel("scatter_last"), pieces.count, *from, primitive_count, pieces.length, shift,
                            b.counts, b.code_low, b.primitive_ids, b.codes);
        } else {
            launcher.launch(kernel("scatter"), pieces.count, *from, primitive_count, pieces.length, shift, b.counts,
                            *to);
        }
        // Pairs are read twice and written once; the last pass of a block looks up a half of the code, the very last
        // writes the whole code beside the primitive.
        const std::uint64_t looked_up = pass % kPassesPerBlock == kPassesPerBlock - 1 ? 4 : 0;
        const std::uint64_t written = pass == 2 * kPassesPerBlock - 1 ? 12 : 8;
        launcher.count_bytes((8 + 8 + looked_up + written) * std::uint64_t{primitive_count});
        std::swap(from, to);
    }
}

}  // namespace clbvh::device
