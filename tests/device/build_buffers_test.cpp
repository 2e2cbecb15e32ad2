// The memory of a build: kept, grown, cut into views that do not meet, and refused before it is asked for.
#include "device/build_buffers.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "device/pipeline.hpp"
#include "device/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::BuildBuffers;
using device::Session;

namespace {

Session& session() {
    return shared_context().session();
}

void reserve(BuildBuffers& buffers, Session& on, std::uint32_t primitives, std::uint64_t extra_bytes = 0) {
    buffers.reserve(on, settings_of(options_of(Shape::lane)), primitives, extra_bytes);
}

/// The buffers that are memory of their own.
std::vector<cl_mem> handles(const BuildBuffers& b) {
    return {b.nodes(), b.primitive_ids(), b.leaves(), b.inner(), b.references(), b.small(), b.extra()};
}

std::uint64_t size_of(const cl::Buffer& buffer) {
    return buffer.getInfo<CL_MEM_SIZE>();
}

struct View {
    std::string name;
    cl::Buffer buffer;
    [[nodiscard]] std::uint64_t begin() const { return buffer.getInfo<CL_MEM_OFFSET>(); }
    [[nodiscard]] std::uint64_t end() const { return begin() + size_of(buffer); }
};

/// Checks that the views lie in `parent`, one behind the other in this order.
void expect_apart(const cl::Buffer& parent, const std::vector<View>& views) {
    std::uint64_t end = 0;
    for (const View& view : views) {
        INFO(view.name);
        CHECK(view.buffer.getInfo<CL_MEM_ASSOCIATED_MEMOBJECT>()() == parent());
        CHECK(view.begin() >= end);
        end = view.end();
    }
    CHECK(end <= size_of(parent));
}

/// This machine's device, said to allocate this much at once.
DeviceInfo device_with_largest_allocation(std::uint64_t bytes) {
    DeviceInfo info = session().info();
    info.max_allocation_bytes = bytes;
    return info;
}

/// Runs the builder on `on` with memory of the caller's and returns the nodes.
std::vector<Node> run_plocpp(Session& on, BuildBuffers& buffers, const device::DeviceMesh& mesh) {
    const ProgressCallback none;
    (void)device::run_pipeline(on, device::kPlocpp, settings_of(options_of(Shape::lane)), none, mesh, buffers);
    std::vector<Node> nodes(2 * std::size_t{mesh.active_count});
    on.queue().enqueueReadBuffer(buffers.nodes, CL_TRUE, 0, nodes.size() * sizeof(Node), nodes.data());
    return nodes;
}

}  // namespace

TEST_CASE("buffers: less than there is room for takes no new memory") {
    BuildBuffers buffers;
    reserve(buffers, session(), 5000, 300);
    const std::vector<cl_mem> before = handles(buffers);
    const std::uint64_t bytes = buffers.bytes;
    for (const auto& [primitives, extra] : {std::pair{5000u, 300u}, {4999u, 300u}, {1u, 0u}, {5000u, 1u}}) {
        reserve(buffers, session(), primitives, extra);
        CHECK(handles(buffers) == before);
    }
    reserve(buffers, session(), 5000, 300);
    CHECK(buffers.bytes == bytes);
}

TEST_CASE("buffers: more primitives or more extra memory grow, and neither shrinks the other") {
    BuildBuffers buffers;
    reserve(buffers, session(), 1000, 5000);
    reserve(buffers, session(), 1001, 10);
    CHECK(size_of(buffers.nodes) >= 64 * 1001);
    CHECK(size_of(buffers.extra) >= 5000);
    reserve(buffers, session(), 10, 6000);
    CHECK(size_of(buffers.nodes) >= 64 * 1001);
    CHECK(size_of(buffers.extra) >= 6000);
    const std::vector<cl_mem> before = handles(buffers);
    reserve(buffers, session(), 1001, 6000);
    CHECK(handles(buffers) == before);
}

TEST_CASE("buffers: the bytes of a build do not depend on the builds before it") {
    for (const std::uint32_t primitives : {1u, 1000u, 100000u}) {
        BuildBuffers fresh;
        reserve(fresh, session(), primitives, 40);
        BuildBuffers used;
        reserve(used, session(), 200000, 5000);
        const std::uint64_t most = used.bytes;
        reserve(used, session(), primitives, 40);
        CHECK(used.bytes == fresh.bytes);
        CHECK(used.bytes < most);
        const std::uint64_t allocated = size_of(fresh.nodes) + size_of(fresh.primitive_ids) + size_of(fresh.leaves) +
                                        size_of(fresh.inner) + size_of(fresh.references) + size_of(fresh.small) +
                                        size_of(fresh.extra);
        CHECK(fresh.bytes <= allocated);
        CHECK(allocated - fresh.bytes <= 64);
    }
}

TEST_CASE("buffers: views that are alive together do not meet, and hold what they are for") {
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t n : {1u, 2u, 1023u, 1024u, 1025u, 100000u}) {
            INFO(to_string(shape) << ", " << n);
            BuildBuffers b;
            b.reserve(session(), settings_of(options_of(shape)), n, 0);
            expect_apart(
                b.inner,
                {{"pairs_a", b.pairs_a}, {"pairs_b", b.pairs_b}, {"code_low", b.code_low}, {"code_high", b.code_high}});
            expect_apart(b.references, {{"references_a", b.references_a}, {"references_b", b.references_b}});
            expect_apart(b.references, {{"codes", b.codes}});
            expect_apart(b.nodes, {{"boxes", b.boxes}});
            expect_apart(b.small, {{"bounds", b.bounds},
                                   {"partial_bounds", b.partial_bounds},
                                   {"counts", b.counts},
                                   {"morton_tables", b.morton_tables},
                                   {"morton_parameters", b.morton_parameters},
                                   {"root_reference", b.root_reference},
                                   {"remaining", b.remaining}});
            CHECK(size_of(b.nodes) >= 64 * std::uint64_t{n});
            CHECK(size_of(b.inner) >= 32 * std::uint64_t{n});
            CHECK(size_of(b.leaves) >= 24 * std::uint64_t{n} + 8);
            CHECK(size_of(b.primitive_ids) >= 4 * std::uint64_t{n});
            CHECK(size_of(b.pairs_a) == 8 * std::uint64_t{n});
            CHECK(size_of(b.codes) == 8 * std::uint64_t{n});
            CHECK(size_of(b.boxes) == 24 * std::uint64_t{n});
            CHECK(size_of(b.counts) >= 4 * BuildBuffers::kMostPieces);
            CHECK(size_of(b.partial_bounds) == 48 * BuildBuffers::kMostPieces);
        }
    }
}

TEST_CASE("buffers: too many primitives for the largest allocation are refused before anything is allocated") {
    Session small(device_with_largest_allocation(64 << 20));  // 64 MiB hold 2^20 sibling pairs
    BuildBuffers buffers;
    reserve(buffers, small, 1000, 100);
    const std::vector<cl_mem> before = handles(buffers);
    expect_error(ErrorCode::unsupported,
                 {"1048577 primitives", "64 MiB at once", "enough for 1048576 primitives", small.info().name},
                 [&] { reserve(buffers, small, (1 << 20) + 1); });
    expect_error(ErrorCode::unsupported, {"128 MiB"}, [&] { reserve(buffers, small, 1000, 128 << 20); });
    CHECK(handles(buffers) == before);
    BuildBuffers fresh;
    CHECK_THROWS_AS(reserve(fresh, small, (1 << 20) + 1), Error);
    CHECK(std::ranges::count(handles(fresh), nullptr) == 7);
    reserve(buffers, small, 1 << 20);
    CHECK(size_of(buffers.nodes) == 64 << 20);
}

TEST_CASE("buffers: a failed allocation holds no memory, and the next one works") {
    Session boastful(device_with_largest_allocation(std::uint64_t{1} << 40));
    BuildBuffers buffers;
    for (const std::uint32_t before : {0u, 1000u}) {
        if (before > 0) reserve(buffers, boastful, before);
        expect_error(ErrorCode::out_of_memory, {}, [&] { reserve(buffers, boastful, (1 << 30) - 1); });
        CHECK(std::ranges::count(handles(buffers), nullptr) == 7);
        reserve(buffers, boastful, 1000, 50);
        CHECK(std::ranges::count(handles(buffers), nullptr) == 0);
        CHECK(size_of(buffers.nodes) == 64 * 1000);
    }
}

TEST_CASE("buffers: a build works after one that found no memory") {
    Session boastful(device_with_largest_allocation(std::uint64_t{1} << 40));
    const device::DeviceMesh mesh = upload_mesh(boastful, random_triangles(3000));
    BuildBuffers buffers;
    const std::vector<Node> expected = run_plocpp(boastful, buffers, mesh);
    device::DeviceMesh too_large = mesh;
    too_large.primitive_count = (1 << 30) - 1;
    expect_error(ErrorCode::out_of_memory, {}, [&] { (void)run_plocpp(boastful, buffers, too_large); });
    const bool same = run_plocpp(boastful, buffers, mesh) == expected;
    CHECK(same);
}
