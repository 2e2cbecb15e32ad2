// The memory of a build: kept, grown, cut into views that do not meet, and refused before it is asked for.
#include "device/build/build_buffers.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "device/build/pipeline.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::BoxOrder;
using device::BuildMemory;
using device::MemoryPlan;
using device::OwnMemory;
using device::Session;

namespace {

Session& session() {
    return shared_context().session();
}

MemoryPlan plan(std::uint32_t primitives, std::uint64_t extra_bytes = 0, BoxOrder box_order = BoxOrder::morton,
                Shape shape = Shape::lane, std::uint32_t code_bits = 44) {
    BuildOptions options = options_of(shape);
    options.device.code_bits = code_bits;
    return device::plan_memory(settings_of(options), box_order, primitives, extra_bytes);
}

std::vector<device::Block> blocks(const BuildMemory& m) {
    return {m.nodes, m.primitive_ids, m.leaves, m.inner, m.references, m.small, m.extra};
}

std::vector<cl_mem> handles(const OwnMemory& own) {
    std::vector<cl_mem> list;
    for (const device::Block& block : blocks(own.memory()))
        list.push_back(block.buffer());
    return list;
}

std::uint64_t size_of(const cl::Buffer& buffer) {
    return buffer.getInfo<CL_MEM_SIZE>();
}

std::uint64_t allocated_bytes(const OwnMemory& own) {
    std::uint64_t sum = 0;
    for (const device::Block& block : blocks(own.memory()))
        sum += block.buffer() != nullptr ? size_of(block.buffer) : 0;
    return sum;
}

struct View {
    std::string name;
    cl::Buffer buffer;
    [[nodiscard]] std::uint64_t begin() const { return buffer.getInfo<CL_MEM_OFFSET>(); }
    [[nodiscard]] std::uint64_t end() const { return begin() + size_of(buffer); }
};

/// Checks that the views lie in `parent`, `begin` bytes into it or later, one behind the other in this order.
void expect_apart(const device::Block& parent, std::uint64_t bytes, const std::vector<View>& views) {
    std::uint64_t end = parent.offset;
    for (const View& view : views) {
        INFO(view.name);
        CHECK(view.buffer.getInfo<CL_MEM_ASSOCIATED_MEMOBJECT>()() == parent.buffer());
        CHECK(view.begin() >= end);
        end = view.end();
    }
    CHECK(end <= parent.offset + bytes);
}

/// The views of every build, and those of each order of boxes, in memory that holds them.
void expect_views_apart(const BuildMemory& m, const MemoryPlan& p) {
    const device::BuildBuffers b = device::cut_views(m, p);
    const std::uint64_t n = p.primitives;
    const std::vector<View> pairs{
        {"pairs_a", b.pairs_a}, {"pairs_b", b.pairs_b}, {"code_low", b.code_low}, {"code_high", b.code_high}};
    const std::vector<View> sort = p.packed_keys ? std::vector<View>{{"keys", b.keys}} : pairs;
    expect_apart(m.nodes, p.nodes, {{"nodes", b.nodes}});
    expect_apart(m.references, p.references, {{"codes", b.codes}});
    expect_apart(m.small, p.small,
                 {{"bounds", b.bounds},
                  {"partial_bounds", b.partial_bounds},
                  {"partial_counts", b.partial_counts},
                  {"primitive_count", b.primitive_count},
                  {"counts", b.counts},
                  {"morton_tables", b.morton_tables},
                  {"morton_parameters", b.morton_parameters},
                  {"root_reference", b.root_reference},
                  {"cluster_counts", b.cluster_counts}});
    if (p.box_order == BoxOrder::morton) {
        expect_apart(m.inner, p.inner, sort);
        expect_apart(m.inner, p.inner, {{"inner", b.inner}});
        expect_apart(m.nodes, p.nodes, {{"boxes", b.boxes}});
        expect_apart(m.leaves, p.leaves, {{"leaves", b.leaves}});
        expect_apart(m.references, p.references, {{"references_a", b.references_a}, {"references_b", b.references_b}});
        CHECK(size_of(b.inner) >= 32 * n);
        CHECK(size_of(b.leaves) >= 24 * n + 8);
    } else {
        if (p.inner > 0) {
            expect_apart(m.inner, p.inner, sort);
        } else {
            expect_apart(m.nodes, p.nodes, sort);
        }
        expect_apart(m.leaves, p.leaves, {{"boxes", b.boxes}});
        CHECK(b.leaves() == nullptr);
    }
    CHECK(size_of(b.nodes) >= 64 * n);
    CHECK(size_of(b.primitive_ids) >= 4 * n);
    CHECK(size_of(sort.front().buffer) == 8 * n);
    CHECK(size_of(b.codes) == 8 * n);
    CHECK(size_of(b.boxes) >= 24 * n + 8);
    CHECK(size_of(b.counts) >= 4 * device::kMostPieces);
    CHECK(size_of(b.partial_bounds) == 48 * device::kMostPieces);
}

/// This machine's device, said to allocate this much at once.
DeviceInfo device_with_largest_allocation(std::uint64_t bytes) {
    DeviceInfo info = session().info();
    info.max_allocation_bytes = bytes;
    return info;
}

/// Runs the builder on `on` with memory of the caller's and returns the nodes.
std::vector<Node> run_plocpp(Session& on, OwnMemory& memory, const device::DeviceMesh& mesh) {
    const ProgressCallback none;
    (void)device::run_pipeline(on, algorithm_of("plocpp"), settings_of(options_of(Shape::lane)), none, mesh, memory,
                               {});
    std::vector<Node> nodes(2 * std::size_t{mesh.active_count});
    on.queue().enqueueReadBuffer(memory.buffers().nodes, CL_TRUE, 0, nodes.size() * sizeof(Node), nodes.data());
    return nodes;
}

}  // namespace

TEST_CASE("buffers: the same plan again makes nothing, and less than there is room for takes no new memory") {
    OwnMemory own;
    own.reserve(session(), plan(5000, 300));
    const std::vector<cl_mem> before = handles(own);
    const cl_mem view = own.buffers().pairs_b();
    own.reserve(session(), plan(5000, 300));
    CHECK(own.buffers().pairs_b() == view);
    for (const auto& [primitives, extra] : {std::pair{4999u, 300u}, {1u, 0u}, {5000u, 1u}}) {
        own.reserve(session(), plan(primitives, extra));
        CHECK(handles(own) == before);
    }
}

TEST_CASE("buffers: more primitives or more extra memory grow, and neither shrinks the other") {
    OwnMemory own;
    const auto holds = [&](std::uint64_t primitives, std::uint64_t extra) {
        return size_of(own.memory().nodes.buffer) >= 64 * primitives && size_of(own.memory().extra.buffer) >= extra;
    };
    own.reserve(session(), plan(1000, 5000));
    own.reserve(session(), plan(1001, 10));
    CHECK(holds(1001, 5000));
    own.reserve(session(), plan(10, 6000));
    CHECK(holds(1001, 6000));
    const std::vector<cl_mem> before = handles(own);
    own.reserve(session(), plan(1001, 6000));
    CHECK(handles(own) == before);
}

TEST_CASE("buffers: a plan says what is allocated for it") {
    for (const BoxOrder box_order : {BoxOrder::morton, BoxOrder::input}) {
        for (const std::uint32_t primitives : {1u, 1000u, 100000u}) {
            OwnMemory own;
            const MemoryPlan planned = plan(primitives, 40, box_order);
            own.reserve(session(), planned);
            CHECK(allocated_bytes(own) == planned.bytes());
        }
    }
    constexpr std::uint64_t n = 100000;
    const std::uint64_t change = plan(n).small + 10 * 4096;
    CHECK(plan(n).bytes() <= 132 * n + change);
    CHECK(plan(n, 0, BoxOrder::input).bytes() <= 100 * n + change);
}

TEST_CASE("buffers: views that are alive together do not meet, and hold what they are for") {
    for (const Shape shape : kBothShapes) {
        for (const BoxOrder box_order : {BoxOrder::morton, BoxOrder::input}) {
            for (const std::uint32_t n : {1u, 2u, 1023u, 1024u, 1025u, 100000u}) {
                INFO(to_string(shape) << ", " << n << (box_order == BoxOrder::input ? ", boxes by primitive" : ""));
                for (const std::uint32_t code_bits : {44u, 63u}) {  // packed keys, and pairs
                    const MemoryPlan planned = plan(n, 0, box_order, shape, code_bits);
                    CHECK(planned.packed_keys == (code_bits < 63));
                    OwnMemory own;
                    own.reserve(session(), planned);
                    expect_views_apart(own.memory(), planned);
                }
            }
        }
    }
}

TEST_CASE("buffers: blocks may be parts of one buffer") {
    for (const BoxOrder box_order : {BoxOrder::morton, BoxOrder::input}) {
        const MemoryPlan planned = plan(3000, 100, box_order);
        device::ArrayLayout sizes;
        sizes.take(4096);
        const std::uint64_t nodes_at = sizes.take(planned.nodes).offset;
        const std::uint64_t ids_at = sizes.take(planned.primitive_ids).offset;
        const std::uint64_t scratch_at = sizes.take(planned.scratch_bytes()).offset;
        const cl::Buffer all(session().context(), CL_MEM_READ_WRITE, sizes.bytes());
        const BuildMemory memory = device::cut_scratch({all, nodes_at}, {all, ids_at}, {all, scratch_at}, planned);
        CHECK(planned.scratch_bytes() >= planned.bytes() - planned.nodes - planned.primitive_ids);
        expect_views_apart(memory, planned);
    }
}

TEST_CASE("buffers: too many primitives for the largest allocation are refused before anything is allocated") {
    Session small(device_with_largest_allocation(64 << 20));  // 64 MiB hold 2^20 sibling pairs
    OwnMemory own;
    own.reserve(small, plan(1000, 100));
    const std::vector<cl_mem> before = handles(own);
    expect_error(ErrorCode::unsupported,
                 {"1048577 primitives", "64 MiB at once", "enough for 1048576 primitives", small.info().name},
                 [&] { own.reserve(small, plan((1 << 20) + 1)); });
    expect_error(ErrorCode::unsupported, {"128 MiB"}, [&] { own.reserve(small, plan(1000, 128 << 20)); });
    device::check_allocations(small, plan(1000), 64 << 20);
    expect_error(ErrorCode::unsupported, {"1000 primitives", "65 MiB"},
                 [&] { device::check_allocations(small, plan(1000), 65 << 20); });
    CHECK(handles(own) == before);
    OwnMemory fresh;
    CHECK_THROWS_AS(fresh.reserve(small, plan((1 << 20) + 1)), Error);
    CHECK(std::ranges::count(handles(fresh), nullptr) == 7);
    own.reserve(small, plan(1 << 20));
    CHECK(size_of(own.memory().nodes.buffer) == 64 << 20);
}

TEST_CASE("buffers: a failed allocation holds no memory, and the next one works") {
    Session boastful(device_with_largest_allocation(std::uint64_t{1} << 40));
    OwnMemory own;
    for (const std::uint32_t before : {0u, 1000u}) {
        if (before > 0) own.reserve(boastful, plan(before));
        expect_error(ErrorCode::out_of_memory, {}, [&] { own.reserve(boastful, plan((1 << 30) - 1)); });
        CHECK(std::ranges::count(handles(own), nullptr) == 7);
        own.reserve(boastful, plan(1000, 50));
        CHECK(std::ranges::count(handles(own), nullptr) == 0);
        CHECK(size_of(own.memory().nodes.buffer) == 64 * 1000);
    }
}

TEST_CASE("buffers: a build works after one that found no memory") {
    Session boastful(device_with_largest_allocation(std::uint64_t{1} << 40));
    const device::DeviceMesh mesh = upload_mesh(boastful, random_triangles(3000));
    OwnMemory memory;
    const std::vector<Node> expected = run_plocpp(boastful, memory, mesh);
    device::DeviceMesh too_large = mesh;
    too_large.primitive_count = (1 << 30) - 1;
    expect_error(ErrorCode::out_of_memory, {}, [&] { (void)run_plocpp(boastful, memory, too_large); });
    const bool same = run_plocpp(boastful, memory, mesh) == expected;
    CHECK(same);
}
