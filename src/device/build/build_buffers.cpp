#include "device/build/build_buffers.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint64_t kNodeBytes = 64;  // a sibling pair a primitive
constexpr std::uint64_t kInnerBytes = 32;
constexpr std::uint64_t kBoxBytes = 24;
constexpr std::uint64_t kIdBytes = 4;
constexpr std::uint64_t kBehindBoxes = 2 * sizeof(float);  // two more words are read, see kernels/cluster/cluster.clh

constexpr std::uint64_t kBoundsBytes = 12 * 4;
constexpr std::uint64_t kTableBytes = 4 * 4 * 256 * 8;
constexpr std::uint64_t kParameterBytes = 16 * 4;
constexpr std::uint64_t kWordBytes = 4;

// The views of a block, one after the other.
class Cutter {
public:
    explicit Cutter(const Block& block) : block_(block) {}
    cl::Buffer take(std::uint64_t bytes) {
        const std::uint64_t begin = end_;
        end_ += align_for_views(bytes);
        return view_of(block_, begin, bytes);
    }

private:
    const Block& block_;
    std::uint64_t end_ = 0;
};

// One array of four bytes a primitive, as far as the next may begin.
std::uint64_t quarter_bytes(std::uint64_t primitives) {
    return align_for_views(4 * primitives);
}

std::uint64_t sort_bytes(const MemoryPlan& plan) {
    return (plan.packed_keys ? 2 : 6) * quarter_bytes(plan.primitives);
}

std::uint64_t count_bytes(std::uint64_t sort_counts) {
    return 4 * std::max<std::uint64_t>(sort_counts, BuildBuffers::kMostPieces);
}

std::uint64_t small_bytes(std::uint64_t sort_counts) {
    std::uint64_t sum = 0;
    for (const std::uint64_t bytes :
         {kBoundsBytes, kBoundsBytes * BuildBuffers::kMostPieces, kWordBytes * BuildBuffers::kMostPieces,
          count_bytes(sort_counts), kTableBytes, kParameterBytes, kWordBytes, kWordBytes,
          kWordBytes * BuildBuffers::kCountsKept}) {
        sum += align_for_views(bytes);
    }
    return sum;
}

void cut_small(BuildBuffers& b, const Block& small, const MemoryPlan& plan) {
    Cutter cutter(small);
    b.bounds = cutter.take(kBoundsBytes);
    b.partial_bounds = cutter.take(kBoundsBytes * BuildBuffers::kMostPieces);
    b.partial_counts = cutter.take(kWordBytes * BuildBuffers::kMostPieces);
    b.counts = cutter.take(count_bytes(plan.sort_counts));
    b.morton_tables = cutter.take(kTableBytes);
    b.morton_parameters = cutter.take(kParameterBytes);
    b.leaf_count = cutter.take(kWordBytes);
    b.root_reference = cutter.take(kWordBytes);
    b.cluster_counts = cutter.take(kWordBytes * BuildBuffers::kCountsKept);
}

void cut_sort(BuildBuffers& b, const Block& block, const MemoryPlan& plan) {
    const std::uint64_t n = plan.primitives;
    Cutter cutter(block);
    if (plan.packed_keys) {
        b.keys = cutter.take(2 * 4 * n);
        return;
    }
    b.pairs_a = cutter.take(2 * 4 * n);
    b.pairs_b = cutter.take(2 * 4 * n);
    b.code_low = cutter.take(4 * n);
    b.code_high = cutter.take(4 * n);
}

}  // namespace

cl::Buffer view_of(const Block& block, std::uint64_t offset, std::uint64_t bytes) {
    const cl_buffer_region region{block.offset + offset, bytes};
    cl::Buffer buffer = block.buffer;  // createSubBuffer is not const
    return buffer.createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &region);
}

MemoryPlan plan_memory(const BuildSettings& settings, BoxOrder box_order, std::uint32_t primitives,
                       std::uint64_t extra_bytes) {
    const std::uint64_t n = primitives;
    MemoryPlan plan;
    plan.box_order = box_order;
    plan.primitives = n;
    plan.packed_keys = settings.packed_keys();
    plan.sort_counts = std::uint64_t{settings.most_sort_pieces} << settings.sort_digit_bits();
    plan.nodes = kNodeBytes * n;
    plan.primitive_ids = kIdBytes * n;
    plan.leaves = kBoxBytes * n + kBehindBoxes;
    plan.references = 2 * quarter_bytes(n);
    plan.small = small_bytes(plan.sort_counts);
    plan.extra = extra_bytes;
    if (box_order == BoxOrder::morton) {
        plan.inner = std::max(kInnerBytes * n, sort_bytes(plan));
    } else if (sort_bytes(plan) > plan.nodes) {
        plan.inner = sort_bytes(plan);
    }
    return plan;
}

BuildMemory cut_scratch(const Block& nodes, const Block& primitive_ids, const Block& scratch, const MemoryPlan& plan) {
    std::uint64_t end = scratch.offset;
    const auto take = [&](std::uint64_t bytes) {
        const Block block{scratch.buffer, end};
        end += align_for_views(bytes);
        return block;
    };
    BuildMemory memory{nodes, primitive_ids, {}, {}, {}, {}, {}};
    memory.leaves = take(plan.leaves);
    memory.inner = take(plan.inner);
    memory.references = take(plan.references);
    memory.small = take(plan.small);
    memory.extra = take(plan.extra);
    return memory;
}

BuildBuffers cut_views(const BuildMemory& memory, const MemoryPlan& plan) {
    const std::uint64_t n = plan.primitives;
    BuildBuffers b;
    b.nodes = view_of(memory.nodes, 0, plan.nodes);
    b.primitive_ids = view_of(memory.primitive_ids, 0, plan.primitive_ids);
    b.codes = view_of(memory.references, 0, 2 * 4 * n);
    if (plan.box_order == BoxOrder::morton) {
        b.boxes = view_of(memory.nodes, 0, kBoxBytes * n + kBehindBoxes);
        b.leaves = view_of(memory.leaves, 0, plan.leaves);
        b.inner = view_of(memory.inner, 0, plan.inner);
        b.references_a = view_of(memory.references, 0, 4 * n);
        b.references_b = view_of(memory.references, quarter_bytes(n), 4 * n);
    } else {
        b.boxes = view_of(memory.leaves, 0, plan.leaves);
    }
    cut_sort(b, plan.inner > 0 ? memory.inner : memory.nodes, plan);
    cut_small(b, memory.small, plan);
    b.extra = memory.extra;
    return b;
}

}  // namespace clbvh::device
