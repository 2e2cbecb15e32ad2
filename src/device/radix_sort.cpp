#include "device/radix_sort.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint32_t kRadix = 256;
constexpr std::uint32_t kDigitBits = 8;
constexpr std::uint32_t kPassesPerBlock = 4;
constexpr std::uint32_t kTile = 1024;

// `step` of the kernel scatter.
enum ScatterStep : cl_uint { kPlain = 0, kRekey = 1, kSplit = 2 };

// The last pass of the first block makes the high half the key; the last of all parts keys and values.
ScatterStep step_of(std::uint32_t pass) {
    if (pass == kPassesPerBlock - 1) return kRekey;
    return pass == 2 * kPassesPerBlock - 1 ? kSplit : kPlain;
}

}  // namespace

void launch_radix_sort(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                       std::uint32_t primitive_count) {
    Session& session = launcher.session();
    const bool lane = settings.sort_shape == Shape::lane;
    const auto kernel = [&](std::string_view name) -> Kernel& {
        return session.kernel("radix_sort.cl", name, settings.sort_group_size, "");
    };
    Kernel& count = kernel("count_digits");
    Kernel& scatter = kernel("scatter");
    const Pieces pieces = cut_into_pieces(primitive_count, settings.most_sort_pieces, lane ? 1 : kTile);
    const cl::Buffer* from = &b.pairs_a;
    const cl::Buffer* to = &b.pairs_b;
    for (std::uint32_t pass = 0; pass < 2 * kPassesPerBlock; ++pass) {
        const std::uint32_t shift = pass % kPassesPerBlock * kDigitBits;
        launcher.launch(count, pieces.count, *from, primitive_count, pieces.length, shift, b.counts);
        if (!lane) {
            launcher.launch(kernel("scan_counts"), 1, b.counts, kRadix * pieces.count);
        }
        const ScatterStep step = step_of(pass);
        launcher.launch(scatter, pieces.count, *from, primitive_count, pieces.length, shift, b.counts, cl_uint{step},
                        step == kRekey ? b.code_high : b.code_low, *to, b.primitive_ids, b.codes);
        std::swap(from, to);
    }
}

}  // namespace clbvh::device
