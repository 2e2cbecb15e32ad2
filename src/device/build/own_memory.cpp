#include <algorithm>
#include <utility>

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

static_assert(std::size(kFields) == OwnMemory::kBlocks);

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
        OwnMemory grown = std::exchange(*this, {});  // after a failure nothing is held
        grown.buffers_ = {};                         // which keep what they are views of
        for (std::size_t i = 0; i < std::size(kFields); ++i) {
            Block& block = grown.memory_.*kFields[i].block;
            block = {};
            block = {grown.blocks_[i].reserve(session, plan.*kFields[i].bytes)};
        }
        grown.buffers_ = cut_views(grown.memory_, plan);
        grown.plan_ = plan;
        *this = std::move(grown);
    });
}

}  // namespace clbvh::device
