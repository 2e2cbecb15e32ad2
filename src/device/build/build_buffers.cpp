#include "device/build/build_buffers.hpp"

#include <algorithm>

#include "kernels/core/core_constants.h"

namespace clbvh::device {
namespace {

constexpr std::uint64_t kNodeBytes = 64;  // a sibling pair a primitive
constexpr std::uint64_t kInnerBytes = sizeof(float) * kernels::RECORD_FLOATS;
constexpr std::uint64_t kBoxBytes = sizeof(float) * kernels::BOX_FLOATS;
constexpr std::uint64_t kIdBytes = 4;
constexpr std::uint64_t kBehindBoxes = 2 * sizeof(float);  // two more words are read, see kernels/cluster/cluster.clh

constexpr std::uint64_t kBoundsBytes = sizeof(float) * kernels::BOUNDS_FLOATS;
constexpr std::uint64_t kTableBytes = sizeof(cl_ulong) * kernels::MORTON_TABLE_ULONGS;
constexpr std::uint64_t kParameterBytes = sizeof(float) * kernels::MORTON_PARAMETERS;
constexpr std::uint64_t kWordBytes = 4;

void cut_sort(BuildBuffers& b, ArrayLayout& layout, const MemoryPlan& plan) {
    const std::uint64_t n = plan.primitives;
    if (plan.packed_keys) {
        b.keys = layout.take_view(8 * n);
        return;
    }
    b.pairs_a = layout.take_view(8 * n);
    b.pairs_b = layout.take_view(8 * n);
    b.code_low = layout.take_view(4 * n);
    b.code_high = layout.take_view(4 * n);
}

void cut_references(BuildBuffers& b, ArrayLayout& layout, const MemoryPlan& plan) {
    b.references_a = layout.take_view(4 * plan.primitives);
    b.references_b = layout.take_view(4 * plan.primitives);
}

void cut_bounds_of_scene(BuildBuffers& b, ArrayLayout& layout) {
    b.bounds = layout.take_view(kBoundsBytes);
    b.partial_bounds = layout.take_view(kBoundsBytes * kMostPieces);
    b.partial_counts = layout.take_view(kWordBytes * kMostPieces);
    b.primitive_count = layout.take_view(kWordBytes);
}

void cut_small(BuildBuffers& b, ArrayLayout& layout, const MemoryPlan& plan) {
    cut_bounds_of_scene(b, layout);
    b.counts = layout.take_view(kWordBytes * std::max<std::uint64_t>(plan.sort_counts, kMostPieces));
    b.morton_tables = layout.take_view(kTableBytes);
    b.morton_parameters = layout.take_view(kParameterBytes);
    if (plan.recodes) {
        b.recode_state = layout.take_view(kWordBytes * kernels::RECODE_ROUNDS * kernels::RECODE_STATE_WORDS);
        b.recode_runs = layout.take_view(kWordBytes * 2 * (plan.primitives / (kernels::LONGEST_RUN + 1) + 1));
    }
    b.root_reference = layout.take_view(kWordBytes);
    b.leaf_count = plan.groups_primitives ? layout.take_view(kWordBytes) : b.primitive_count;
    b.cluster_counts = layout.take_view(kWordBytes * BuildBuffers::kCountsKept);
}

// Bytes of a part of this plan.
std::uint64_t bytes_of(void (*cut)(BuildBuffers&, ArrayLayout&, const MemoryPlan&), const MemoryPlan& plan) {
    ArrayLayout layout;
    BuildBuffers none;
    cut(none, layout, plan);
    return layout.bytes();
}

BuildMemory lay_out_scratch(ArrayLayout& layout, const MemoryPlan& plan) {
    BuildMemory memory;
    memory.leaves = layout.take(plan.leaves);
    memory.inner = layout.take(plan.inner);
    memory.references = layout.take(plan.references);
    memory.small = layout.take(plan.small);
    memory.extra = layout.take(plan.extra);
    return memory;
}

}  // namespace

MemoryPlan plan_memory(const BuildSettings& settings, BoxOrder box_order, std::uint32_t primitives,
                       std::uint64_t extra_bytes) {
    const std::uint64_t n = primitives;
    MemoryPlan plan;
    plan.box_order = box_order;
    plan.primitives = n;
    plan.packed_keys = settings.packed_keys();
    plan.recodes = settings.recodes();
    plan.groups_primitives = settings.groups_primitives();
    plan.sort_counts = std::uint64_t{settings.most_sort_pieces} << settings.sort_digit_bits();
    plan.nodes = kNodeBytes * n;
    plan.primitive_ids = kIdBytes * n;
    plan.leaves = kBoxBytes * n + kBehindBoxes;
    plan.references = bytes_of(cut_references, plan);  // no less than the codes, 8 n
    plan.small = bytes_of(cut_small, plan);
    plan.extra = extra_bytes;
    const std::uint64_t sort_bytes = bytes_of(cut_sort, plan);
    if (box_order == BoxOrder::morton) {
        plan.inner = std::max(kInnerBytes * n, sort_bytes);
    } else if (sort_bytes > plan.nodes) {
        plan.inner = sort_bytes;
    }
    return plan;
}

std::uint64_t MemoryPlan::scratch_bytes() const {
    ArrayLayout layout;
    lay_out_scratch(layout, *this);
    return layout.bytes();
}

BuildMemory cut_scratch(const Block& nodes, const Block& primitive_ids, const Block& scratch, const MemoryPlan& plan) {
    ArrayLayout layout(scratch);
    BuildMemory memory = lay_out_scratch(layout, plan);
    memory.nodes = nodes;
    memory.primitive_ids = primitive_ids;
    return memory;
}

BuildBuffers cut_bounds(ArrayLayout& layout, std::uint64_t primitives) {
    BuildBuffers b;
    b.boxes = layout.take_view(kBoxBytes * primitives);
    cut_bounds_of_scene(b, layout);
    return b;
}

BuildBuffers cut_views(const BuildMemory& memory, const MemoryPlan& plan) {
    const std::uint64_t n = plan.primitives;
    BuildBuffers b;
    b.nodes = view_of(memory.nodes, 0, plan.nodes);
    b.primitive_ids = view_of(memory.primitive_ids, 0, plan.primitive_ids);
    b.codes = view_of(memory.references, 0, 8 * n);
    if (plan.box_order == BoxOrder::morton) {
        b.boxes = view_of(memory.nodes, 0, kBoxBytes * n + kBehindBoxes);
        b.leaves = view_of(memory.leaves, 0, plan.leaves);
        b.inner = view_of(memory.inner, 0, plan.inner);
        ArrayLayout references(memory.references);
        cut_references(b, references, plan);
    } else {
        b.boxes = view_of(memory.leaves, 0, plan.leaves);
    }
    ArrayLayout sort(plan.inner > 0 ? memory.inner : memory.nodes);
    cut_sort(b, sort, plan);
    ArrayLayout small(memory.small);
    cut_small(b, small, plan);
    b.extra = memory.extra;
    return b;
}

}  // namespace clbvh::device
