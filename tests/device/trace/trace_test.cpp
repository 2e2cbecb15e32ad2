#include "device/trace/trace.hpp"

#include <catch2/catch.hpp>

#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::device;
using namespace clbvh::test;

TEST_CASE("trace: scratch holds a stack for any tree, and more of them for small trees") {
    for (const std::uint32_t nodes : {0u, 2u, 200u, 200000u, 20000000u, 0x7FFFFFFEu}) {
        INFO(nodes);
        const TraceScratch scratch = lay_out_trace_scratch(nodes);
        CHECK(scratch.deep_items >= 1);
        CHECK(scratch.deep_items <= 64);
        // Every entry is for another inner node, which has a sibling pair of its own beside the root's.
        CHECK(scratch.deep_capacity >= nodes / 2);
        CHECK(scratch.bytes == 64 + std::uint64_t{8} * scratch.deep_items * scratch.deep_capacity);
        CHECK(scratch.bytes <= std::max<std::uint64_t>(64 + (16 << 20), 72 + 4 * std::uint64_t{nodes}));
    }
    CHECK(lay_out_trace_scratch(200).deep_items == 64);
    CHECK(lay_out_trace_scratch(20000000).deep_items == 1);
}

TEST_CASE("trace: automatic options follow the shape") {
    Session& session = shared_context().session();
    DeviceTracerOptions options;
    options.shape = Shape::lane;
    const TraceSettings lane = resolve_trace_settings(session, options);
    CHECK(lane.work_group_size == 1);
    CHECK(lane.block_rays == 64);
    options.shape = Shape::group;
    const TraceSettings group = resolve_trace_settings(session, options);
    CHECK(group.work_group_size > 1);
    CHECK(group.block_rays == group.work_group_size);
    options.work_group_size = 32;
    CHECK(resolve_trace_settings(session, options).block_rays == 32);
    CHECK(trace_program(group).options != trace_program(resolve_trace_settings(session, options)).options);
    options.shape = Shape::automatic;
    CHECK(resolve_trace_settings(session, options).shape ==
          (session.prefers_lane_shape() ? Shape::lane : Shape::group));
}
