#include "device/build_buffers.hpp"

#include <algorithm>

namespace clbvh::device {
namespace {

constexpr std::uint64_t kNodeBytes = 64;  // a sibling pair a primitive
constexpr std::uint64_t kInnerBytes = 32;
constexpr std::uint64_t kBoxBytes = 24;
constexpr std::uint64_t kIdBytes = 4;
constexpr std::uint64_t kBehindBoxes = 2 * sizeof(float);  // two more words are read, see kernels/cluster.clh

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

std::uint64_t sort_bytes(std::uint64_t primitives) {
    return 6 * quarter_bytes(primitives);
}

std::uint64_t count_bytes(std::uint64_t most_sort_pieces) {
    return 4 * std::max<std::uint64_t>(256 * most_sort_pieces, BuildBuffers::kMostPieces);
}

std::uint64_t small_bytes(std::uint64_t most_sort_pieces) {
    std::uint64_t sum = 0;
    for (const std::uint64_t bytes :
         {kBoundsBytes, kBoundsBytes * BuildBuffers::kMostPieces, kWordBytes * BuildBuffers::kMostPieces,
          count_bytes(most_sort_pieces), kTableBytes, kParameterBytes, kWordBytes, kWordBytes, kWordBytes}) {
        sum += align_for_views(bytes);
    }
    return sum;
}

void cut_small(BuildBuffers& b, const Block& small, const MemoryPlan& plan) {
    Cutter cutter(small);
    b.bounds = cutter.take(kBoundsBytes);
    b.partial_bounds = cutter.take(kBoundsBytes * BuildBuffers::kMostPieces);
    b.partial_counts = cutter.take(kWordBytes * BuildBuffers::kMostPieces);
    b.counts = cutter.take(count_bytes(plan.most_sort_pieces));
    b.morton_tables = cutter.take(kTableBytes);
    b.morton_parameters = cutter.take(kParameterBytes);
    b.leaf_count = cutter.take(kWordBytes);
    b.root_reference = cutter.take(kWordBytes);
    b.remaining = cutter.take(kWordBytes);
}

void cut_sort(BuildBuffers& b, const Block& block, std::uint64_t n) {
    Cutter cutter(block);
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
    plan.most_sort_pieces = settings.most_sort_pieces;
    plan.nodes = kNodeBytes * n;
    plan.primitive_ids = kIdBytes * n;
    plan.leaves = kBoxBytes * n + kBehindBoxes;
    plan.references = 2 * quarter_bytes(n);
    plan.small = small_bytes(plan.most_sort_pieces);
    plan.extra = extra_bytes;
    if (box_order == BoxOrder::morton) {
        plan.inner = std::max(kInnerBytes * n, sort_bytes(n));
    } else if (sort_bytes(n) > plan.nodes) {
        plan.inner = sort_bytes(n);
    }
    return plan;
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
    cut_sort(b, plan.inner > 0 ? memory.inner : memory.nodes, n);
    cut_small(b, memory.small, plan);
    b.extra = memory.extra;
    return b;
}

}  // namespace clbvh::device
