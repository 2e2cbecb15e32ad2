#include "clbvh/io/layout_file.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "clbvh/builder.hpp"
#include "clbvh/core/primitives.hpp"
#include "clbvh/io/bvh_file.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/layout/make_layout.hpp"
#include "core/random.hpp"
#include "io/binary_file.hpp"
#include "io/file_fields.hpp"
#include "io/temp_folder.hpp"
#include "layout/layout_checks.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

template <typename Layout>
Layout layout_of(const Bvh& bvh, const Mesh& mesh) {
    Layout layout;
    if constexpr (requires { layout.primitive_ids; }) {
        make_layout(bvh, layout);
    } else {
        make_layout(bvh, mesh, layout);
    }
    return layout;
}

/// Calls check(layout) with the layout of each kind.
template <typename Check>
void for_each_kind(const Bvh& bvh, const Mesh& mesh, const Check& check) {
    check(layout_of<Wide8>(bvh, mesh));
    check(layout_of<Wide4>(bvh, mesh));
    check(layout_of<Compressed8>(bvh, mesh));
    check(layout_of<PairLayout>(bvh, mesh));
    check(layout_of<SkipLayout>(bvh, mesh));
}

template <typename Layout>
bool same_layouts(const Layout& a, const Layout& b) {
    const auto same_others = [&] {
        if constexpr (requires { a.blocks; }) {
            return same_elements(a.blocks, b.blocks);
        } else if constexpr (requires { a.triangles; }) {
            return same_elements(a.triangles, b.triangles);
        } else {
            return same_elements(a.primitive_ids, b.primitive_ids);
        }
    };
    return same_elements(a.nodes, b.nodes) && same_others() && a.depth == b.depth &&
           a.primitive_count == b.primitive_count && a.split_references == b.split_references;
}

template <typename Layout>
std::string bytes_of(const Layout& layout) {
    const TempFolder folder;
    write_layout(layout, folder.path("layout"));
    return content_of(folder.path("layout"));
}

template <typename Layout>
void expect_refused(const std::string& bytes, const std::string& reason) {
    const TempFolder folder;
    const std::string path = folder.write("layout", bytes);
    expect_error(ErrorCode::io, {path, reason}, [&] { (void)read_layout<Layout>(path); });
}

/// With the hash that belongs to the other bytes.
std::string with_hash(const std::string& bytes) {
    const auto all = std::as_bytes(std::span(bytes.data(), bytes.size()));
    return with_field(bytes, 56, io::hash_bytes({all.first(56), all.subspan(64)}));
}

Mesh small_mesh() {
    return generate_scene("soup", 40);
}

}  // namespace

TEST_CASE("a layout of any kind is read as it was written") {
    const Mesh mesh = generate_scene("hair", 300), one = generate_scene("soup", 1);
    const TempFolder folder;
    for (const auto& [bvh, over] :
         {std::pair{build(mesh, "sweep-sah"), &mesh}, {build(mesh, "sbvh"), &mesh}, {build(one, "median"), &one}}) {
        for_each_kind(bvh, *over, [&, &triangles = *over](const auto& layout) {
            write_layout(layout, folder.path("layout"));
            std::remove_cvref_t<decltype(layout)> read;
            read_layout(folder.path("layout"), read);
            CHECK(same_layouts(read, layout));
            CHECK_NOTHROW(validate(read, triangles));
            CHECK(folder.entry_count() == 1);
        });
    }
}

TEST_CASE("a layout of nothing is read as it was written") {
    Bvh inactive;
    inactive.primitive_count = 1;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Mesh mesh{{{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    for_each_kind(inactive, mesh, [&](const auto& layout) {
        const TempFolder folder;
        const std::string path = folder.write("layout", bytes_of(layout));
        CHECK(content_of(path).size() == 64);
        std::remove_cvref_t<decltype(layout)> read =
            layout_of<std::remove_cvref_t<decltype(layout)>>(build(small_mesh(), "median"), small_mesh());
        read_layout(path, read);
        CHECK(same_layouts(read, layout));
        CHECK_NOTHROW(validate(read, mesh));
    });
}

TEST_CASE("a layout's file is laid out as documented") {
    const Mesh mesh = small_mesh();
    const Bvh bvh = build(mesh, "sbvh");
    REQUIRE(bvh.split_references);
    constexpr std::array<std::array<std::uint32_t, 3>, 5> kinds = {
        {{1, 224, 160}, {2, 112, 160}, {3, 80, 48}, {4, 64, 4}, {5, 32, 4}}};
    std::size_t next = 0;
    for_each_kind(bvh, mesh, [&](const auto& layout) {
        const auto [kind, node_bytes, element_bytes] = kinds[next++];
        INFO("kind " << kind);
        const std::string bytes = bytes_of(layout);
        CHECK(bytes.substr(0, 8) == std::string_view("CLBVHL\0\1", 8));
        CHECK(field<std::uint32_t>(bytes, 8) == kind);
        CHECK(field<std::uint32_t>(bytes, 12) == node_bytes);
        CHECK(field<std::uint32_t>(bytes, 16) == element_bytes);
        CHECK(field<std::uint32_t>(bytes, 20) == layout.depth);
        CHECK(field<std::uint64_t>(bytes, 24) == layout.nodes.size());
        CHECK(bytes.size() == 64 + layout.nodes.size() * node_bytes + field<std::uint64_t>(bytes, 32) * element_bytes);
        CHECK(field<std::uint64_t>(bytes, 40) == 40);
        CHECK(field<std::uint32_t>(bytes, 48) == 1);
        CHECK(field<std::uint32_t>(bytes, 52) == 0);
        CHECK(std::memcmp(bytes.data() + 64, layout.nodes.data(), layout.nodes.size() * node_bytes) == 0);
        CHECK(with_hash(bytes) == bytes);
    });
    CHECK(next == kinds.size());
}

TEST_CASE("what a layout's file holds can be asked for without reading it") {
    const Mesh mesh = small_mesh();
    const TempFolder folder;
    const Wide8 layout = make_layout<Wide8>(build(mesh, "median"), mesh);
    write_layout(layout, folder.path("layout"));
    CHECK(is_layout_file(folder.path("layout")));
    const LayoutFileInfo info = read_layout_info(folder.path("layout"));
    CHECK(to_string(info.kind) == "wide8");
    CHECK(info.node_count == layout.nodes.size());
    CHECK(info.element_count == layout.blocks.size());
    CHECK(info.primitive_count == 40);
    CHECK(info.depth == layout.depth);
    CHECK_FALSE(info.split_references);
    CHECK(info.file_bytes == 64 + 224 * layout.nodes.size() + 160 * layout.blocks.size());

    write_bvh(build(mesh, "median"), folder.path("tree"));
    CHECK_FALSE(is_layout_file(folder.path("tree")));
    CHECK_FALSE(is_layout_file(folder.write("short", "CLBVHL")));
    expect_error(ErrorCode::io, {"not a layout file"}, [&] { (void)read_layout_info(folder.path("tree")); });
    expect_error(ErrorCode::io, {"not a BVH file"}, [&] { (void)read_bvh(folder.path("layout")); });
    expect_error(ErrorCode::io, {"No such file"}, [&] { (void)is_layout_file(folder.path("none")); });
}

TEST_CASE("kinds of layouts have names, and what is no kind has none") {
    CHECK(to_string(LayoutKind::wide8) == "wide8");
    CHECK(to_string(LayoutKind::skip) == "skip");
    CHECK(to_string(LayoutKind{0}).empty());
    CHECK(to_string(LayoutKind{6}).empty());
}

TEST_CASE("a layout of another kind is refused, and what was there stays") {
    const Mesh mesh = small_mesh();
    const Bvh bvh = build(mesh, "median");
    const TempFolder folder;
    for_each_kind(bvh, mesh, [&](const auto& written) {
        write_layout(written, folder.path("layout"));
        const std::string kind(to_string(read_layout_info(folder.path("layout")).kind));
        for_each_kind(bvh, mesh, [&](const auto& expected) {
            auto layout = expected;
            if constexpr (std::is_same_v<decltype(written), decltype(expected)>) {
                CHECK_NOTHROW(read_layout(folder.path("layout"), layout));
            } else {
                expect_error(ErrorCode::io, {"a layout of kind " + kind + ", not "},
                             [&] { read_layout(folder.path("layout"), layout); });
            }
            CHECK(same_layouts(layout, expected));
        });
    });
}

TEST_CASE("a damaged byte or a cut does not get past the reader of layouts") {
    const Mesh mesh = generate_scene("soup", 3);
    for_each_kind(build(mesh, "median"), mesh, [&](const auto& layout) {
        using Layout = std::remove_cvref_t<decltype(layout)>;
        const std::string bytes = bytes_of(layout);
        const TempFolder folder;
        std::size_t refused = 0;
        const auto count_refusal = [&](const std::string& damaged) {
            const std::string path = folder.write("layout", damaged);
            try {
                (void)read_layout<Layout>(path);
            } catch (const Error& error) {
                refused += error.code() == ErrorCode::io ? 1 : 0;
            }
        };
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            std::string damaged = bytes;
            damaged[i] = static_cast<char>(damaged[i] ^ (1 << i % 8));
            count_refusal(damaged);
            count_refusal(bytes.substr(0, i));
        }
        count_refusal(bytes + '\0');
        CHECK(refused == 2 * bytes.size() + 1);
    });
}

TEST_CASE("headers of layouts that lie are refused before memory is set aside") {
    const Mesh mesh = small_mesh();
    const std::string bytes = bytes_of(make_layout<Wide8>(build(mesh, "median"), mesh));
    expect_refused<Wide8>("CLBVHL", "too short for the header of a layout file");
    expect_refused<Wide8>(bytes.substr(0, 100), "bytes follow it");
    for (const std::uint64_t count : {11ULL, 1ULL << 40, 1ULL << 59, ~0ULL}) {
        expect_refused<Wide8>(with_hash(with_field(bytes, 24, count)), std::to_string(count) + " nodes");
        expect_refused<Wide8>(with_hash(with_field(bytes, 32, count)), std::to_string(count) + " blocks");
    }
    // 2^59 nodes of 224 bytes are 0 bytes modulo 2^64.
    const std::uint64_t all_blocks = (bytes.size() - 64) / 160;
    expect_refused<Wide8>(with_field(with_field(bytes, 24, 1ULL << 59), 32, all_blocks), "bytes follow it");
    expect_refused<Wide8>(with_field(bytes, 40, kMaxPrimitives + 1), "more than the limit");
    expect_refused<Wide8>(with_field(bytes, 0, 'X'), "not a layout file");
    expect_refused<Wide8>(with_field(bytes, 7, '\2'), "version 2 of the format; this library reads version 1");
    expect_refused<Wide8>(with_field(bytes, 8, std::uint32_t{6}), "layouts of kind 6");
    expect_refused<Wide8>(with_field(bytes, 8, std::uint32_t{2}), "nodes of 224 bytes, not 112");
    expect_refused<Wide8>(with_field(bytes, 16, std::uint32_t{64}), "blocks of 64 bytes, not 160");
    expect_refused<Wide8>(with_field(bytes, 48, std::uint32_t{2}), "unknown flags 2");
    expect_refused<Wide8>(with_field(bytes, 52, std::uint32_t{1}), "reserved");
    expect_refused<Wide8>(with_field(bytes, 20, std::uint32_t{0}), "the hash does not match");
    expect_refused<Wide8>(with_hash(with_field(bytes, 20, std::uint32_t{7777})), "a depth of 7777, above its");
}

TEST_CASE("whatever a layout's file holds, it is refused, or validate says what it is worth") {
    const Mesh mesh = generate_scene("soup", 30);
    Random random(7);
    for (const char* const id : {"sweep-sah", "sbvh"}) {
        for_each_kind(build(mesh, id), mesh, [&](const auto& layout) {
            using Layout = std::remove_cvref_t<decltype(layout)>;
            const std::string bytes = bytes_of(layout);
            const std::vector<Ray> rays = difficult_rays(mesh, 1);
            const TempFolder folder;
            std::array<int, 3> outcomes{};  // refused by the reader, by validate, by none
            for (int round = 0; round < 1000; ++round) {
                std::string damaged = bytes;
                for (std::uint32_t change = random.below(3); change < 3; ++change) {
                    // Headers are a small part of files, and yet what matters most.
                    const std::size_t at = random.below(4) == 0
                                               ? 8 + random.below(48)
                                               : random.below(static_cast<std::uint32_t>(bytes.size()));
                    damaged[at] = static_cast<char>(random.below(256));
                }
                if (round % 8 == 0) damaged.resize(random.below(static_cast<std::uint32_t>(bytes.size())));
                if (round % 4 != 1 && damaged.size() >= 64) damaged = with_hash(damaged);
                std::size_t outcome = 0;
                try {
                    const Layout read = read_layout<Layout>(folder.write("layout", damaged));
                    outcome = 1;
                    validate(read, mesh);
                    outcome = 2;
                    for (const Ray& ray : rays)
                        (void)closest_in(read, mesh, ray);
                } catch (const Error& error) {
                    CHECK(error.code() == (outcome == 0 ? ErrorCode::io : ErrorCode::invalid_input));
                }
                ++outcomes[outcome];
            }
            CHECK(outcomes[0] > 100);
            CHECK(outcomes[1] > 100);
        });
    }
}

TEST_CASE("a layout's target that cannot be written is reported, and nothing is left there") {
    const TempFolder folder;
    std::filesystem::create_directory(folder.path("folder"));
    expect_error(ErrorCode::io, {folder.path("folder").string(), "Is a directory"},
                 [&] { write_layout(Wide8{}, folder.path("folder")); });
    CHECK(folder.entry_count() == 1);
    CHECK(std::filesystem::is_empty(folder.path("folder")));
}
