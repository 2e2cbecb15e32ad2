#include "device/radix_sort.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint32_t kRadix = 256;
constexpr std::uint32_t kDigitBits = 8;
constexpr std::uint32_t kPassesPerBlock = 4;
// A lane keeps a counter and an open cache line for each digit, so few long pieces beat many short ones.
constexpr std::uint32_t kLanePiecesPerUnit = 4;
constexpr std::uint32_t kTile = 1024;

Pieces cut(const BuildSettings& settings, const DeviceInfo& info, std::uint32_t pairs) {
    const std::uint32_t most = settings.lane() ? info.compute_units * kLanePiecesPerUnit : settings.groups_to_fill;
    return cut_into_pieces(pairs, std::min(most, BuildBuffers::kMostPieces), settings.lane() ? 1 : kTile);
}

}  // namespace

void launch_radix_sort(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                       std::uint32_t primitive_count) {
    Session& session = launcher.session();
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return session.kernel("radix_sort.cl", name, settings.stream_group_size, "");
    };
    Kernel& count = kernel("count_digits");
    Kernel& scan = kernel("scan_counts");
    const Pieces pieces = cut(settings, session.info(), primitive_count);
    const cl::Buffer* from = &b.pairs_a;
    const cl::Buffer* to = &b.pairs_b;
    for (std::uint32_t pass = 0; pass < 2 * kPassesPerBlock; ++pass) {
        const std::uint32_t shift = pass % kPassesPerBlock * kDigitBits;
        launcher.launch(count, pieces.count, *from, primitive_count, pieces.length, shift, b.counts);
        launcher.launch(scan, 1, b.counts, kRadix * pieces.count);
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
        std::swap(from, to);
    }
}

}  // namespace clbvh::device
