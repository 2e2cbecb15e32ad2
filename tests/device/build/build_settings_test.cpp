// What automatic options become on devices of all kinds. The devices are this machine's, said to be something else.
#include "device/build/build_settings.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "catalog/device_configs.hpp"
#include "clbvh/options.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::BuildSettings;
using device::Pieces;
using device::Session;

namespace {

DeviceInfo real_device() {
    return shared_context().device();
}

DeviceInfo gpu(std::uint64_t local_kib, bool int64_atomics = true) {
    DeviceInfo info = real_device();
    info.type = DeviceType::gpu;
    info.local_memory_bytes = local_kib << 10;
    info.max_work_group_size = 1024;
    info.compute_units = 32;
    info.int64_atomics = int64_atomics;
    return info;
}

DeviceInfo cpu(std::uint64_t local_kib) {
    DeviceInfo info = real_device();
    info.type = DeviceType::cpu;
    info.local_memory_bytes = local_kib << 10;
    info.max_work_group_size = 4096;
    info.compute_units = 8;
    return info;
}

BuildSettings resolve(const BuildOptions& options, const DeviceInfo& info) {
    Session session(info);
    return device::resolve_settings(algorithm_of("plocpp"), options, session);
}

/// Options of one shape where all else is automatic.
BuildOptions shape_only(Shape shape) {
    BuildOptions options;
    options.device.shape = shape;
    return options;
}

BuildOptions with_radius(Shape shape, std::uint32_t radius) {
    BuildOptions options = shape_only(shape);
    options.ploc.search_radius = radius;
    return options;
}

void expect_refused(ErrorCode code, std::initializer_list<std::string> parts, const BuildOptions& options,
                    const DeviceInfo& info) {
    expect_error(code, parts, [&] { (void)resolve(options, info); });
}

/// Local memory of the kernel with most of it, as the compiler counts it.
std::uint64_t local_bytes_of_search(Session& session, const BuildSettings& settings) {
    device::Kernel& kernel =
        session.kernel("plocpp.cl", "search_merge", settings.cluster_group_size, settings.search_defines());
    const cl::Device device(static_cast<cl_device_id>(session.info().id), true);
    return kernel.kernel.getWorkGroupInfo<CL_KERNEL_LOCAL_MEM_SIZE>(device);
}

}  // namespace

TEST_CASE("settings: the automatic shape is lane on CPUs that pass the self-test, group elsewhere") {
    CHECK(resolve({}, gpu(64)).shape == Shape::group);
    CHECK(resolve({}, gpu(64)).sort_shape == Shape::group);
    Session session(cpu(2048));
    const Shape on_cpu = session.prefers_lane_shape() ? Shape::lane : Shape::group;
    CHECK(device::resolve_settings(algorithm_of("plocpp"), {}, session).shape == on_cpu);
    CHECK(device::resolve_settings(algorithm_of("plocpp"), {}, session).sort_shape == on_cpu);
    for (const Shape shape : {Shape::group, Shape::lane}) {
        CHECK(resolve(shape_only(shape), gpu(2048)).shape == shape);
        CHECK(resolve(shape_only(shape), cpu(2048)).shape == shape);
        BuildOptions options;
        options.device.sort_shape = shape;
        CHECK(resolve(options, gpu(64)).sort_shape == shape);
        CHECK(resolve(options, gpu(64)).shape == Shape::group);
    }
}

TEST_CASE("settings: packed keys give the code the bits that the index leaves") {
    const BuildSettings settings = resolve({}, cpu(2048));
    CHECK(settings.packed_keys());
    for (const auto& [primitives, index_bits, code_bits] : std::vector<std::array<std::uint32_t, 3>>{
             {1, 0, 44}, {2, 1, 44}, {3, 2, 44}, {1 << 20, 20, 44}, {(1 << 20) + 1, 21, 43}, {(1 << 30) - 1, 30, 34}}) {
        INFO(primitives);
        CHECK(settings.key_layout(primitives).index_bits == index_bits);
        CHECK(settings.key_layout(primitives).code_bits == code_bits);
    }
    BuildOptions options;
    options.device.code_bits = 33;
    CHECK(resolve(options, cpu(2048)).key_layout(1 << 30).code_bits == 33);
    options.device.code_bits = 63;
    CHECK_FALSE(resolve(options, cpu(2048)).packed_keys());
}

TEST_CASE("settings: automatic searches are symmetric on GPUs and scans on CPUs") {
    const BuildOptions options = shape_only(Shape::group);
    CHECK(resolve(options, gpu(64)).symmetric_search);
    CHECK_FALSE(resolve(options, cpu(2048)).symmetric_search);
    CHECK_FALSE(resolve(options, gpu(64)).exact_distances);
    BuildOptions explicit_options = options;
    explicit_options.ploc.neighbour_search = NeighbourSearch::scan;
    CHECK_FALSE(resolve(explicit_options, gpu(64)).symmetric_search);
    explicit_options.ploc.neighbour_search = NeighbourSearch::symmetric;
    CHECK(resolve(explicit_options, cpu(2048)).symmetric_search);
}

TEST_CASE("settings: exact symmetric searches need 64-bit atomics") {
    BuildOptions options = shape_only(Shape::group);
    options.ploc.neighbour_encoding = NeighbourEncoding::bits64;
    CHECK(resolve(options, gpu(64, true)).symmetric_search);
    CHECK(resolve(options, gpu(64, true)).exact_distances);
    CHECK_FALSE(resolve(options, gpu(64, false)).symmetric_search);
    options.ploc.neighbour_search = NeighbourSearch::symmetric;
    CHECK(resolve(options, gpu(64, true)).symmetric_search);
    expect_refused(ErrorCode::unsupported, {"bits64", "64-bit atomics", real_device().name, "scan"}, options,
                   gpu(64, false));
    options.device.shape = Shape::lane;
    CHECK(resolve(options, gpu(64, false)).exact_distances);
}

TEST_CASE("settings: a group is as large as local memory and the device allow") {
    const BuildOptions options = shape_only(Shape::group);
    CHECK(resolve(options, gpu(64)).cluster_group_size == 1024);
    CHECK(resolve(options, gpu(32)).cluster_group_size == 512);
    CHECK(resolve(options, cpu(2048)).cluster_group_size == 256);
    DeviceInfo small = gpu(64);
    small.max_work_group_size = 300;
    CHECK(resolve(options, small).cluster_group_size == 256);
    small.max_work_group_size = 200;
    CHECK(resolve(options, small).cluster_group_size == 128);
    CHECK(resolve(options, small).stream_group_size == 128);
    CHECK(resolve(options, small).sort_group_size == 128);
    CHECK(resolve(options, gpu(64)).stream_group_size == 256);
}

TEST_CASE("settings: a lane's groups have one work item, and its chunk fits local memory") {
    const BuildSettings settings = resolve(shape_only(Shape::lane), cpu(2048));
    CHECK(settings.cluster_group_size == 1);
    CHECK(settings.stream_group_size == 1);
    CHECK(settings.chunk_size(32) == settings.lane_chunk_size);
    const std::uint32_t smaller = resolve(with_radius(Shape::lane, 16), cpu(64)).lane_chunk_size;
    CHECK(smaller >= 64);
    CHECK(smaller < settings.lane_chunk_size);
    CHECK(resolve(shape_only(Shape::group), cpu(2048)).chunk_size(32) == 256 - 64);
}

TEST_CASE("settings: group sizes and radii that contradict each other are refused") {
    for (const auto& [group, radius] : {std::pair{32u, 8u}, {64u, 16u}, {128u, 32u}}) {
        BuildOptions options = with_radius(Shape::group, radius);
        options.ploc.work_group_size = group;
        expect_refused(ErrorCode::invalid_input,
                       {"work_group_size " + std::to_string(group), "search_radius = " + std::to_string(4 * radius)},
                       options, gpu(64));
        options.ploc.search_radius = radius - 1;
        CHECK(resolve(options, gpu(64)).chunk_size(2 * (radius - 1)) == group - 4 * (radius - 1));
        CHECK(resolve(options, gpu(64)).cluster_group_size == group);
    }
}

TEST_CASE("settings: what a device cannot hold is refused with its limit") {
    BuildOptions options = shape_only(Shape::group);
    options.ploc.work_group_size = 1024;
    expect_refused(ErrorCode::unsupported, {"work_group_size 1024", real_device().name, "512"}, options, gpu(32));
    options = shape_only(Shape::lane);
    options.ploc.chunk_size = 4096;
    CHECK(resolve(options, cpu(2048)).lane_chunk_size == 4096);
    expect_refused(ErrorCode::unsupported, {"chunk_size 4096", "65536 bytes", real_device().name}, options, cpu(64));
    expect_refused(ErrorCode::unsupported, {"local memory", "8192 bytes"}, shape_only(Shape::lane), cpu(8));
}

TEST_CASE("settings: Morton ranges are as many as asked for, else the same in both shapes") {
    BuildOptions options = shape_only(Shape::group);
    options.ploc.range_count = 3;
    CHECK(resolve(options, gpu(64)).range_count == 3);
    DeviceInfo large = gpu(2048);
    large.compute_units = 1000;
    for (const DeviceInfo& info : {cpu(2048), gpu(2048), large}) {
        const std::uint32_t group = resolve(shape_only(Shape::group), info).range_count;
        CHECK(group == resolve(shape_only(Shape::lane), info).range_count);
        CHECK(group >= 256);
        CHECK(group <= 512);
    }
}

TEST_CASE("settings: H-PLOC's options are its kernels' constants") {
    BuildOptions options;
    options.hploc = {.search_radius = 31,
                     .cluster_limit = 8,
                     .small_range = 5,
                     .small_limit = 3,
                     .merge_pairs = false,
                     .leaf_size = 4};
    const BuildSettings settings = resolve(options, gpu(64));
    CHECK(algorithm_of("hploc").program(settings).options ==
          " -D CLUSTER_LIMIT=8 -D SMALL_RANGE=5 -D SMALL_LIMIT=3 -D MERGE_PAIRS=0 -D SEARCH_RADIUS=31 -D LEAF_SIZE=4");
    CHECK(settings.groups_primitives());
    CHECK_FALSE(resolve({}, gpu(64)).groups_primitives());
}

TEST_CASE("settings: options that a builder does not read are neither checked nor followed") {
    const auto resolve_for = [](std::string_view builder, const BuildOptions& options) {
        Session session(gpu(64, false));
        return device::resolve_settings(algorithm_of(builder), device_configs_for(builder, options), session);
    };
    BuildOptions options = with_radius(Shape::group, 32);
    options.ploc.work_group_size = 64;
    CHECK_THROWS_AS(resolve_for("plocpp", options), Error);
    CHECK(resolve_for("lbvh", options).configs.ploc.search_radius == 16);
    CHECK(resolve_for("hploc", options).cluster_group_size == 256);
    options = shape_only(Shape::group);
    options.ploc.neighbour_encoding = NeighbourEncoding::bits64;
    options.ploc.neighbour_search = NeighbourSearch::symmetric;
    options.hploc.cluster_limit = 8;
    CHECK_THROWS_AS(resolve_for("plocpp", options), Error);
    CHECK_FALSE(resolve_for("ploc", options).exact_distances);
    CHECK(resolve_for("ploc", options).configs.hploc.cluster_limit == 16);
    CHECK(resolve_for("hploc", options).configs.hploc.cluster_limit == 8);
}

TEST_CASE("settings: what they let pass, the compiler fits in local memory") {
    for (const std::uint32_t radius : {1u, 16u, 32u}) {
        for (const NeighbourEncoding encoding : {NeighbourEncoding::bits32, NeighbourEncoding::bits64}) {
            for (const Shape shape : {Shape::group, Shape::lane}) {
                BuildOptions options = with_radius(shape, radius);
                options.ploc.neighbour_encoding = encoding;
                options.ploc.neighbour_search = NeighbourSearch::scan;
                Session session(shape == Shape::group ? gpu(32) : cpu(96));
                const BuildSettings settings = device::resolve_settings(algorithm_of("plocpp"), options, session);
                INFO(to_string(shape) << ", radius " << radius << ", " << to_string(encoding) << ", groups of "
                                      << settings.cluster_group_size << ", chunk " << settings.chunk_size(2 * radius));
                const std::uint64_t bytes = local_bytes_of_search(session, settings);
                CHECK(bytes > settings.chunk_size(2 * radius) * 6 * sizeof(float));
                CHECK(bytes <= session.info().local_memory_bytes);
            }
        }
    }
}

TEST_CASE("pieces: equal, whole grains, none empty, never too many") {
    for (const std::uint32_t granularity : {1u, 16u, 256u, 1000u}) {
        for (const std::uint32_t most : {1u, 2u, 7u, 1024u}) {
            for (const std::uint32_t elements : {1u, 2u, 255u, 256u, 257u, 1000u, 7000u, 7001u, 123457u, 1073741823u}) {
                const Pieces pieces = device::cut_into_pieces(elements, most, granularity);
                INFO(elements << " in at most " << most << " of " << granularity << ": " << pieces.count << " of "
                              << pieces.length);
                CHECK(pieces.count <= most);
                CHECK(pieces.length % granularity == 0);
                CHECK(std::uint64_t{pieces.count} * pieces.length >= elements);
                CHECK((std::uint64_t{pieces.count} - 1) * pieces.length < elements);
            }
        }
    }
    CHECK(device::cut_into_pieces(0, 8, 256).count == 1);
}
