#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "clbvh/core/bvh.hpp"
#include "device/build/stage_bench.hpp"
#include "device/tree/reinsert.hpp"
#include "support/builders.hpp"

namespace clbvh::test {

/// Of all nodes, how many are candidates of the first pass: more than passes begin with, since the trees are small.
inline constexpr float kPart = 0.0625f;

/// Found of kernels/tree/reinsert_state.clh.
struct Found {
    std::uint32_t from, to, pivot;
    float gain;
};

inline device::OptimizeSettings optimize_settings(Shape shape) {
    device::OptimizeSettings settings;
    static_cast<device::DeviceFit&>(settings) = device::fit_to_device(shared_context().session(), shape);
    return settings;
}

/// A tree on the device, and the steps of reinsertion on it.
class Steps {
public:
    Steps(const Bvh& tree, Shape shape)
        : settings_(optimize_settings(shape)),
          bench_(options_of(shape), 1),
          node_count_(static_cast<std::uint32_t>(tree.nodes.size())),
          nodes_(shared_context().session().context(), CL_MEM_READ_WRITE, tree.nodes.size() * sizeof(Node)),
          scratch_(shared_context().session().context(), CL_MEM_READ_WRITE,
                   device::kReinsert.scratch_bytes(settings_, node_count_)),
          job_{bench_.launcher, settings_, {nodes_, node_count_, {}}, {scratch_, 0}},
          passes(job_) {
        write(nodes_, tree.nodes);
        fill_bytes(scratch_, 0x5a);
        passes.begin();
        set_control(kernels::PART, std::bit_cast<std::uint32_t>(kPart));
    }

    [[nodiscard]] std::vector<Node> nodes() const { return read<Node>(nodes_, node_count_); }
    [[nodiscard]] std::vector<std::uint32_t> words(const cl::Buffer& buffer) const {
        return read<std::uint32_t>(buffer, buffer.getInfo<CL_MEM_SIZE>() / 4);
    }
    [[nodiscard]] std::vector<std::uint16_t> ranks() const {
        return read<std::uint16_t>(passes.views().ranks, node_count_);
    }
    [[nodiscard]] std::int64_t area() const { return read<std::int64_t>(passes.views().area, 1)[0]; }
    [[nodiscard]] std::uint32_t control(std::size_t word) const { return words(passes.views().control)[word]; }
    void set_control(std::size_t word, std::uint32_t value) {
        std::vector<std::uint32_t> control = words(passes.views().control);
        control[word] = value;
        write(passes.views().control, control);
    }
    [[nodiscard]] std::vector<Found> found() const {
        std::vector<Found> all = read<Found>(passes.views().found, passes.sizes().candidates);
        all.resize(control(kernels::CANDIDATES));
        return all;
    }
    /// Those that were moved.
    [[nodiscard]] std::vector<Found> moved() const {
        const std::vector<std::uint32_t> state = words(passes.views().state);
        std::vector<Found> moves;
        const std::vector<Found> all = found();
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (state[i] == 1) moves.push_back(all[i]);
        }
        return moves;
    }
    void move() {
        passes.choose();
        passes.search();
        passes.lock();
        passes.move();
        passes.refit(false);
    }

private:
    device::OptimizeSettings settings_;
    StageBench bench_;
    std::uint32_t node_count_;
    cl::Buffer nodes_, scratch_;
    device::OptimizeJob job_;

public:
    device::ReinsertPasses passes;
};

}  // namespace clbvh::test
