#include <algorithm>

#include "clbvh/core/error.hpp"
#include "device/build/build_buffers.hpp"
#include "device/opencl/device_memory.hpp"

namespace clbvh::device {
namespace {

struct Field {
    Block BuildMemory::*block;
    std::uint64_t MemoryPlan::*bytes;
};
constexpr Field kFields[] = {
    {&BuildMemory::nodes, &MemoryPlan::nodes},           {&BuildMemory::primitive_ids, &MemoryPlan::primitive_ids},
    {&BuildMemory::leaves, &MemoryPlan::leaves},         {&BuildMemory::inner, &MemoryPlan::inner},
    {&BuildMemory::references, &MemoryPlan::references}, {&BuildMemory::small, &MemoryPlan::small},
    {&BuildMemory::extra, &MemoryPlan::extra},
};

bool is_within(const MemoryPlan& plan, const MemoryPlan& capacity) {
    return std::ranges::all_of(kFields, [&](const Field& f) { return plan.*f.bytes <= capacity.*f.bytes; });
}

MemoryPlan larger_of(const MemoryPlan& a, const MemoryPlan& b) {
    MemoryPlan plan = a;
    for (const Field& field : kFields) {
        plan.*field.bytes = std::max(a.*field.bytes, b.*field.bytes);
    }
    return plan;
}

BuildMemory allocate(const Session& session, const MemoryPlan& plan) {
    BuildMemory memory;
    for (const Field& field : kFields) {
        if (plan.*field.bytes > 0) {
            memory.*field.block = {allocate_buffer(session, plan.*field.bytes), 0};
        }
    }
    return memory;
}

}  // namespace

void check_allocations(const Session& session, const MemoryPlan& plan, std::uint64_t scratch_bytes) {
    const std::uint64_t most = session.info().max_allocation_bytes;
    std::uint64_t largest = scratch_bytes;
    for (const Field& field : kFields) {
        largest = std::max(largest, plan.*field.bytes);
    }
    if (largest > most) {
        const std::uint64_t bytes_each = std::max(largest, plan.nodes) / plan.primitives;
        throw Error(ErrorCode::unsupported, std::to_string(plan.primitives) + " primitives need a buffer of " +
                                                std::to_string(largest >> 20) + " MiB, but " + session.info().name +
                                                " allocates at most " + std::to_string(most >> 20) +
                                                " MiB at once, enough for " + std::to_string(most / bytes_each) +
                                                " primitives; build in parts");
    }
}

void OwnMemory::reserve(Session& session, const MemoryPlan& plan) {
    if (plan == plan_) {
        return;
    }
    check_allocations(session, plan);
    with_opencl_errors("memory for " + std::to_string(plan.primitives) + " primitives", [&] {
        if (!is_within(plan, capacity_)) {
            // Buffers that are too small go first, so that old and new are never alive together; after a failure
            // nothing is held.
            const MemoryPlan grown = larger_of(capacity_, plan);
            *this = OwnMemory{};
            memory_ = allocate(session, grown);
            capacity_ = grown;
        }
        buffers_ = cut_views(memory_, plan);
        plan_ = plan;
    });
}

}  // namespace clbvh::device
