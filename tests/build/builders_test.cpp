// Every builder of the table gives the tree that its definition gives, node for node and byte for byte: in both
// shapes, for every search radius, on every generated scene, at sizes around every chunk and work-group boundary.
#include <algorithm>
#include <catch2/catch.hpp>

#include "clbvh/device/context.hpp"
#include "clbvh/io/scene.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

const std::vector<std::uint32_t> kSmallSizes{0,  1,  2,  3,  4,  5,  15,  16,  17,  31,  32,  33,
                                             63, 64, 65, 95, 96, 97, 127, 128, 129, 255, 256, 257};
const std::vector<std::uint32_t> kLargeSizes{511, 512, 513, 959, 960, 961, 991, 992, 993, 1023, 1024, 1025, 3001, 9001};

/// Those that read any of what differs from the plain options of the same shape, with which all are compared once;
/// all where nothing differs.
std::vector<Builder> make_builders(const BuildOptions& options) {
    const BuildOptions plain = options_of(options.device.shape);
    std::vector<std::string_view> changed;
    for (const OptionInfo& option : clbvh::options()) {
        if (get_option(options, option.name) != get_option(plain, option.name)) changed.push_back(option.name);
    }
    std::vector<Builder> result;
    for (const std::string_view id : device_builders()) {
        const auto is_read = [&](std::string_view name) { return reads_option(id, name); };
        if (changed.empty() || std::ranges::any_of(changed, is_read)) result.push_back(make_builder(id, options));
    }
    return result;
}

/// Small chunks and an early last kernel, so that small inputs fill many of them.
BuildOptions fine_options(Shape shape, std::uint32_t radius) {
    BuildOptions options = options_of(shape, radius);
    options.ploc.single_group_threshold = 20;
    options.ploc.chunk_size = 64;
    options.ploc.work_group_size = radius == 32 ? 256 : 128;
    options.ploc.range_count = 5;
    return options;
}

void expect_oracle_trees(std::vector<Builder>& builders, const std::vector<std::uint32_t>& sizes) {
    for (const SceneGeneratorInfo& scene : scene_generators()) {
        for (const std::uint32_t size : sizes) {
            const Mesh mesh = generate_scene(scene.name, size);
            const std::string where = std::string(scene.name) + ":" + std::to_string(size);
            for (Builder& builder : builders) {
                if (!expect_oracle_tree(builder, builder.build(mesh), mesh, where)) return;
            }
        }
    }
}

void expect_oracle_trees(Shape shape, std::uint32_t radius) {
    std::vector<Builder> builders = make_builders(options_of(shape, radius));
    REQUIRE(builders.size() >= 3);
    expect_oracle_trees(builders, kSmallSizes);
    expect_oracle_trees(builders, kLargeSizes);
    std::vector<Builder> fine_builders = make_builders(fine_options(shape, radius));
    expect_oracle_trees(fine_builders, kSmallSizes);
    expect_oracle_trees(fine_builders, kLargeSizes);
}

void expect_oracle_trees(const BuildOptions& options) {
    std::vector<Builder> builders = make_builders(options);
    expect_oracle_trees(builders, {2, 3, 65, 1025, 5000});
}

}  // namespace

TEST_CASE("builders equal their oracles: group shape, radius 1") {
    expect_oracle_trees(Shape::group, 1);
}
TEST_CASE("builders equal their oracles: group shape, radius 8") {
    expect_oracle_trees(Shape::group, 8);
}
TEST_CASE("builders equal their oracles: group shape, radius 16") {
    expect_oracle_trees(Shape::group, 16);
}
TEST_CASE("builders equal their oracles: group shape, radius 32") {
    expect_oracle_trees(Shape::group, 32);
}
TEST_CASE("builders equal their oracles: lane shape, radius 1") {
    expect_oracle_trees(Shape::lane, 1);
}
TEST_CASE("builders equal their oracles: lane shape, radius 8") {
    expect_oracle_trees(Shape::lane, 8);
}
TEST_CASE("builders equal their oracles: lane shape, radius 16") {
    expect_oracle_trees(Shape::lane, 16);
}
TEST_CASE("builders equal their oracles: lane shape, radius 32") {
    expect_oracle_trees(Shape::lane, 32);
}

TEST_CASE("builders equal their oracles: the last radii before offsets need one bit more") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::uint32_t radius : {3u, 7u, 15u, 31u})
            expect_oracle_trees(options_of(shape, radius));
    }
}

TEST_CASE("builders equal their oracles: extended Morton codes") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        BuildOptions options = options_of(shape);
        options.device.morton_code = MortonCode::extended;
        expect_oracle_trees(options);
    }
}

TEST_CASE("builders equal their oracles: packed keys of few bits, and pairs") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::uint32_t code_bits : {33u, 63u}) {
            BuildOptions options = options_of(shape);
            options.device.sort_shape = shape;
            options.device.code_bits = code_bits;
            expect_oracle_trees(options);
        }
    }
}

TEST_CASE("builders equal their oracles: both searches with both encodings") {
    for (const NeighbourSearch search : {NeighbourSearch::scan, NeighbourSearch::symmetric}) {
        for (const NeighbourEncoding encoding : {NeighbourEncoding::bits32, NeighbourEncoding::bits64}) {
            for (const Shape shape : {Shape::group, Shape::lane}) {
                const bool needs_atomics = search == NeighbourSearch::symmetric &&
                                           encoding == NeighbourEncoding::bits64 && shape == Shape::group;
                if (needs_atomics && !shared_context().device().int64_atomics) {
                    WARN("left out: " << shared_context().device().name << " has no 64-bit atomics");
                    continue;
                }
                BuildOptions options = fine_options(shape, 16);
                options.ploc.neighbour_search = search;
                options.ploc.neighbour_encoding = encoding;
                expect_oracle_trees(options);
            }
        }
    }
}

TEST_CASE("builders equal their oracles: other numbers of ranges") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (const std::uint32_t ranges : {1u, 2u, 3u, 64u, 511u, 512u}) {
            BuildOptions options = options_of(shape);
            options.ploc.range_count = ranges;
            Builder builder = make_builder("plocpp-two-level", options);
            for (const std::uint32_t size : {1u, 2u, 16u, 17u, 1000u, 20000u}) {
                const Mesh mesh = generate_scene("city", size);
                expect_oracle_tree(builder, builder.build(mesh), mesh, std::to_string(ranges) + " ranges");
            }
        }
    }
}

TEST_CASE("builders equal their oracles: other chunk and work-group sizes") {
    const Mesh mesh = generate_scene("clustered", 10000);
    const auto check = [&](const BuildOptions& options, std::uint32_t size) {
        for (Builder& builder : make_builders(options)) {
            expect_oracle_tree(builder, builder.build(mesh), mesh, "size " + std::to_string(size));
        }
    };
    for (const std::uint32_t chunk : {192u, 1024u, 4096u}) {
        BuildOptions options = options_of(Shape::lane);
        options.ploc.chunk_size = chunk;
        options.ploc.single_group_threshold = 100;
        check(options, chunk);
    }
    for (const std::uint32_t group : {256u, 512u}) {
        BuildOptions options = options_of(Shape::group);
        options.ploc.work_group_size = group;
        options.ploc.single_group_threshold = 100;
        check(options, group);
    }
    BuildOptions smallest = options_of(Shape::group, 4);
    smallest.ploc.work_group_size = 32;
    check(smallest, 32);
}

TEST_CASE("builders equal their oracles: coordinates at the ends of the range") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (Builder& builder : make_builders(options_of(shape))) {
            for (const float scale : {1e17f, 1e-15f}) {
                Mesh mesh = random_triangles(2000);
                for (Vec3& v : mesh.vertices)
                    v = {v.x * scale / 1.05f, v.y * scale / 1.05f, v.z * scale / 1.05f};
                expect_oracle_tree(builder, builder.build(mesh), mesh, "scale " + std::to_string(scale));
            }
            Mesh mesh = random_triangles(2000);
            mesh.vertices[0] = {kMaxCoordinate, -kMaxCoordinate, kMaxCoordinate};
            mesh.vertices[3] = {-kMaxCoordinate, kMaxCoordinate, -kMaxCoordinate};
            expect_oracle_tree(builder, builder.build(mesh), mesh, "two outliers");
        }
    }
}

TEST_CASE("builders equal their oracles: negative zeros") {
    Mesh mesh = random_triangles(300);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        if (i % 3 == 0) mesh.vertices[i].x = -0.0f;
        if (i % 4 == 0) mesh.vertices[i].y = 0.0f * mesh.vertices[i].y;
        mesh.vertices[i].z = i % 2 == 0 ? -0.0f : 0.0f;
    }
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (Builder& builder : make_builders(options_of(shape))) {
            expect_oracle_tree(builder, builder.build(mesh), mesh, "negative zeros");
        }
    }
}

TEST_CASE("builders equal their oracles: some primitives inactive") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        for (Builder& builder : make_builders(options_of(shape))) {
            for (const std::size_t step : {1u, 2u, 3u, 50u}) {
                for (const std::size_t size : {1u, 2u, 65u, 3000u}) {
                    Mesh mesh = random_triangles(size);
                    deactivate_triangles(mesh, 0, step);
                    BuildStats stats;
                    const Bvh bvh = builder.build(mesh, &stats);
                    const std::size_t inactive = (size + step - 1) / step;
                    CHECK(stats.inactive_primitives == inactive);
                    CHECK(bvh.nodes.size() == 2 * (size - inactive));
                    expect_oracle_tree(builder, bvh, mesh, "each of " + std::to_string(step) + " inactive");
                }
            }
        }
    }
}

TEST_CASE("plocpp and plocpp-two-level of one range build ploc's tree with the exact encoding") {
    for (const Shape shape : {Shape::group, Shape::lane}) {
        BuildOptions options = options_of(shape);
        options.ploc.neighbour_encoding = NeighbourEncoding::bits64;
        options.ploc.range_count = 1;
        for (const SceneGeneratorInfo& scene : scene_generators()) {
            const Mesh mesh = generate_scene(scene.name, 20000);
            const Bvh expected = make_builder("ploc", options).build(mesh);
            INFO(scene.name << ", " << to_string(shape));
            CHECK(same_bytes(make_builder("plocpp", options).build(mesh), expected));
            CHECK(same_bytes(make_builder("plocpp-two-level", options).build(mesh), expected));
        }
    }
}
