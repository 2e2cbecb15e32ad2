#include "device/build/radix_sort.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint32_t kKeyBitsOfPair = 32;

// The passes that sort elements by `bits` bits above `low_bit`, and where each finds its digit.
struct Digits {
    std::uint32_t low_bit;
    std::uint32_t bits;
    std::uint32_t digit_bits;

    [[nodiscard]] std::uint32_t passes() const { return (bits + digit_bits - 1) / digit_bits; }
    [[nodiscard]] std::uint32_t shift(std::uint32_t pass) const { return low_bit + pass * digit_bits; }
    [[nodiscard]] std::uint32_t mask(std::uint32_t pass) const {
        return (1u << std::min(digit_bits, bits - pass * digit_bits)) - 1;
    }
};

Digits digits_of_keys(const BuildSettings& settings, std::uint32_t primitive_count) {
    const KeyLayout layout = settings.key_layout(primitive_count);
    return {layout.index_bits, layout.code_bits, settings.sort_digit_bits()};
}

// One launch of the sort's kernels after the other over the same elements.
class Passes {
public:
    Passes(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& buffers,
           std::uint32_t primitive_count)
        : launcher_(launcher),
          settings_(settings),
          counts_(buffers.counts),
          primitive_count_(primitive_count),
          pieces_(settings.sort_pieces(primitive_count)) {}

    void count(const cl::Buffer& from, std::uint32_t shift, std::uint32_t mask) {
        launcher_.launch(kernel("count_digits"), pieces_.count, from, primitive_count_, pieces_.length, shift, mask,
                         counts_);
        launcher_.count_bytes(std::uint64_t{8} * primitive_count_);
    }

    /// Scatters by the digit that was counted. `bytes` are what an element has read and written beside itself.
    template <typename... Arguments>
    void scatter(std::string_view name, std::uint64_t bytes, const cl::Buffer& from, std::uint32_t shift,
                 std::uint32_t mask, const Arguments&... arguments) {
        if (settings_.sort_shape != Shape::lane) {
            launcher_.launch(kernel("scan_digits"), 1, counts_, pieces_.count << settings_.sort_digit_bits());
        }
        launcher_.launch(kernel(name), pieces_.count, from, primitive_count_, pieces_.length, shift, mask, counts_,
                         arguments...);
        launcher_.count_bytes((8 + 8 + bytes) * primitive_count_);
    }

private:
    Kernel& kernel(std::string_view name) { return launcher_.session().kernel(radix_sort_program(settings_), name); }

    Launcher& launcher_;
    const BuildSettings& settings_;
    const cl::Buffer& counts_;
    std::uint32_t primitive_count_;
    Pieces pieces_;
};

void sort_packed_keys(Passes& passes, const BuildSettings& settings, const BuildBuffers& b,
                      std::uint32_t primitive_count) {
    const Digits digits = digits_of_keys(settings, primitive_count);
    const std::uint32_t index_mask = (1u << digits.low_bit) - 1;
    const cl::Buffer* from = &unsorted_keys(settings, b, primitive_count);
    const cl::Buffer* to = from == &b.codes ? &b.keys : &b.codes;
    for (std::uint32_t pass = 0; pass < digits.passes(); ++pass) {
        const std::uint32_t shift = digits.shift(pass);
        const std::uint32_t mask = digits.mask(pass);
        if (pass > 0) passes.count(*from, shift, mask);
        if (pass + 1 == digits.passes()) {
            passes.scatter("scatter_ids", 4, *from, shift, mask, index_mask, *to, b.primitive_ids);
        } else {
            passes.scatter("scatter", 0, *from, shift, mask, *to);
        }
        std::swap(from, to);
    }
}

void sort_pairs(Passes& passes, const BuildSettings& settings, const BuildBuffers& b) {
    const Digits digits{0, kKeyBitsOfPair, settings.sort_digit_bits()};
    const std::uint32_t last = digits.passes() - 1;
    const cl::Buffer* from = &b.pairs_a;
    const cl::Buffer* to = &b.pairs_b;
    for (const bool is_high_half : {false, true}) {
        for (std::uint32_t pass = 0; pass <= last; ++pass) {
            const std::uint32_t shift = digits.shift(pass);
            const std::uint32_t mask = digits.mask(pass);
            passes.count(*from, shift, mask);
            if (pass < last) {
                passes.scatter("scatter", 0, *from, shift, mask, *to);
            } else if (!is_high_half) {
                passes.scatter("scatter_rekey", 4, *from, shift, mask, b.code_high, *to);
            } else {
                passes.scatter("scatter_last", 8, *from, shift, mask, b.code_low, b.codes, b.primitive_ids);
            }
            std::swap(from, to);
        }
    }
}

}  // namespace

ProgramSpec radix_sort_program(const BuildSettings& settings) {
    return {"radix_sort.cl", settings.sort_group_size, ""};
}

const cl::Buffer& unsorted_keys(const BuildSettings& settings, const BuildBuffers& b, std::uint32_t primitive_count) {
    return digits_of_keys(settings, primitive_count).passes() % 2 == 0 ? b.codes : b.keys;
}

void launch_count_keys(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                       std::uint32_t primitive_count) {
    const Digits digits = digits_of_keys(settings, primitive_count);
    Passes(launcher, settings, b, primitive_count)
        .count(unsorted_keys(settings, b, primitive_count), digits.shift(0), digits.mask(0));
}

void launch_radix_sort(Launcher& launcher, const BuildSettings& settings, const BuildBuffers& b,
                       std::uint32_t primitive_count) {
    Passes passes(launcher, settings, b, primitive_count);
    if (settings.packed_keys()) {
        sort_packed_keys(passes, settings, b, primitive_count);
    } else {
        sort_pairs(passes, settings, b);
    }
}

}  // namespace clbvh::device
