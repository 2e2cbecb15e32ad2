#include "clbvh/io/bvh_file.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

#include "clbvh/core/primitives.hpp"
#include "io/file_fields.hpp"
#include "io/temp_folder.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

Node inner(std::uint32_t first) {
    return {{-1, -2, -3}, first, {4, 5, 6}, 0};
}

Node leaf(std::uint32_t first, std::uint32_t count) {
    return {{0, 0, 0.5f}, first, {1, 1, 1}, count};
}

/// Four leaves; the pair of nodes 4 and 5 is one that nothing refers to.
Bvh small_bvh() {
    Bvh bvh;
    bvh.nodes = {inner(2),   {},         inner(8),   inner(6),   inner(77),
                 leaf(9, 9), leaf(0, 1), leaf(1, 2), leaf(3, 1), leaf(4, 1)};
    bvh.primitive_ids = {4, 0, 6, 2, 1};
    bvh.primitive_count = 7;
    return bvh;
}

bool same(const Bvh& a, const Bvh& b) {
    return a.nodes == b.nodes && a.primitive_ids == b.primitive_ids && a.primitive_count == b.primitive_count &&
           a.split_references == b.split_references;
}

std::string bytes_of(const Bvh& bvh) {
    const TempFolder folder;
    write_bvh(bvh, folder.path("tree.bvh"));
    return content_of(folder.path("tree.bvh"));
}

void expect_refused(const std::string& bytes, const std::string& reason) {
    const TempFolder folder;
    const std::string path = folder.write("tree.bvh", bytes);
    expect_error(ErrorCode::io, {path, reason}, [&] { (void)read_bvh(path); });
}

/// A tree that is written with its own hash, and refused for what `spoil` did to it.
void expect_refused_tree(const std::string& reason, const std::function<void(Bvh&)>& spoil) {
    Bvh bvh = small_bvh();
    spoil(bvh);
    expect_refused(bytes_of(bvh), reason);
}

}  // namespace

TEST_CASE("a tree is read as it was written") {
    Bvh single;
    single.nodes = {leaf(0, 1), {}};
    single.primitive_ids = {0};
    single.primitive_count = 1;
    Bvh inactive;
    inactive.primitive_count = 12;
    Bvh split = small_bvh();
    split.primitive_ids = {4, 0, 4, 2, 0};
    split.split_references = true;
    for (const Bvh& bvh : {small_bvh(), single, inactive, split, Bvh{}}) {
        const TempFolder folder;
        write_bvh(bvh, folder.path("tree.bvh"));
        CHECK(same(read_bvh(folder.path("tree.bvh")), bvh));
        CHECK(folder.entry_count() == 1);
    }
}

TEST_CASE("the file is laid out as documented") {
    const std::string bytes = bytes_of(small_bvh());
    CHECK(bytes.size() == 64 + 10 * 32 + 5 * 4);
    CHECK(bytes.substr(0, 8) == std::string_view("CLBVH\0\0\1", 8));
    CHECK(field<std::uint64_t>(bytes, 8) == 10);
    CHECK(field<std::uint64_t>(bytes, 16) == 5);
    CHECK(field<std::uint64_t>(bytes, 24) == 7);
    CHECK(field<std::uint32_t>(bytes, 32) == 0);
    CHECK(field<std::uint32_t>(bytes, 36) == 32);
    CHECK(field<std::uint64_t>(bytes, 40) == 0);
    CHECK(field<std::uint64_t>(bytes, 56) == 0);
    CHECK(field<Node>(bytes, 64 + 7 * 32) == leaf(1, 2));
    CHECK(field<std::uint32_t>(bytes, 64 + 10 * 32 + 8) == 6);
    // xxh64 of nothing with seed 0, as published with the algorithm.
    CHECK(field<std::uint64_t>(bytes_of({}), 48) == 0xEF46DB3751D8E999U);
}

TEST_CASE("split references are the lowest bit of the flags") {
    Bvh bvh = small_bvh();
    bvh.split_references = true;
    CHECK(field<std::uint32_t>(bytes_of(bvh), 32) == 1);
}

TEST_CASE("no single damaged byte gets past the reader") {
    const std::string bytes = bytes_of(small_bvh());
    const TempFolder folder;
    std::size_t accepted = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        // Fields that nothing else in the file depends on: more primitives may be inactive than were, and references
        // may be called split.
        const bool primitive_count = i >= 24 && i < 32;
        const bool split_flag = i == 32;
        for (const int flip : {0x01, 0x80}) {
            std::string damaged = bytes;
            damaged[i] = static_cast<char>(damaged[i] ^ flip);
            const std::string path = folder.write("tree.bvh", damaged);
            try {
                const Bvh read = read_bvh(path);
                ++accepted;
                INFO("byte " << i << " flipped by " << flip);
                CHECK((primitive_count || split_flag));
                CHECK((read.nodes == small_bvh().nodes && read.primitive_count > 6));
                CHECK(read.split_references == split_flag);
            } catch (const Error& error) {
                CHECK(error.code() == ErrorCode::io);
            }
        }
    }
    CHECK(accepted > 0);
}

TEST_CASE("a file of any other length is refused") {
    const std::string bytes = bytes_of(small_bvh());
    for (std::size_t size = 0; size < bytes.size(); ++size)
        expect_refused(bytes.substr(0, size), size < 64 ? "too short" : "bytes follow");
    expect_refused(bytes + '\0', "bytes follow");
}

TEST_CASE("headers that lie are refused before memory is set aside") {
    const std::string bytes = bytes_of(small_bvh());
    for (const std::uint64_t count : {11ULL, 1ULL << 40, 1ULL << 59, ~0ULL}) {
        expect_refused(with_field(bytes, 8, count), std::to_string(count) + " nodes");
        expect_refused(with_field(bytes, 16, count), std::to_string(count) + " ids");
    }
    // 2^59 nodes of 32 bytes are 0 bytes modulo 2^64.
    expect_refused(with_field(with_field(bytes, 8, 1ULL << 59), 16, std::uint64_t{85}), "bytes follow");
    expect_refused(with_field(bytes, 24, ~std::uint64_t{0}), "more than the limit");
    expect_refused(with_field(bytes, 24, kMaxPrimitives + 1), "more than the limit");
    expect_refused(with_field(bytes, 0, 'X'), "not a BVH file");
    expect_refused(with_field(bytes, 7, '\2'), "version 2");
    expect_refused(with_field(bytes, 32, std::uint32_t{4}), "unknown flags 4");
    expect_refused(with_field(bytes, 32, std::uint32_t{3}), "unknown flags 3");
    expect_refused(with_field(bytes, 36, std::uint32_t{64}), "nodes of 64 bytes");
    expect_refused(with_field(bytes, 40, std::uint64_t{1}), "reserved");
    expect_refused(with_field(bytes, 56, std::uint64_t{1}), "reserved");
    expect_refused(with_field(bytes, 48, std::uint64_t{1}), "the hash does not match");
}

TEST_CASE("a tree of as many primitives as there may be is read") {
    Bvh bvh = small_bvh();
    bvh.primitive_count = kMaxPrimitives;
    const TempFolder folder;
    CHECK(read_bvh(folder.write("tree.bvh", bytes_of(bvh))).primitive_count == kMaxPrimitives);
}

TEST_CASE("trees that would lead a traversal astray are refused") {
    expect_refused_tree("node 0: its children 3 and 4 start at an odd index", [](Bvh& bvh) { bvh.nodes[0].first = 3; });
    expect_refused_tree("node 3: its children 0 and 1 have another parent, or are the root",
                        [](Bvh& bvh) { bvh.nodes[3].first = 0; });
    expect_refused_tree("node 3: its children 10 and 11 are out of range", [](Bvh& bvh) { bvh.nodes[3].first = 10; });
    expect_refused_tree("node 3: its children 4294967294", [](Bvh& bvh) { bvh.nodes[3].first = 0xFFFFFFFEU; });
    expect_refused_tree("node 3: its children 2 and 3 have another parent", [](Bvh& bvh) { bvh.nodes[3].first = 2; });
    expect_refused_tree("its children 8 and 9 have another parent", [](Bvh& bvh) { bvh.nodes[3].first = 8; });
    expect_refused_tree("node 7: its primitive range ends at 6", [](Bvh& bvh) { bvh.nodes[7] = leaf(1, 5); });
    expect_refused_tree("node 6: its primitive range ends at",
                        [](Bvh& bvh) { bvh.nodes[6] = leaf(0xFFFFFFFFU, 0xFFFFFFFFU); });
    expect_refused_tree("id 2 names primitive 7 of 7", [](Bvh& bvh) { bvh.primitive_ids[2] = 7; });
    expect_refused_tree("node 1 is not", [](Bvh& bvh) { bvh.nodes[1] = leaf(0, 1); });
    expect_refused_tree("ids without nodes", [](Bvh& bvh) { bvh.nodes.clear(); });
}

TEST_CASE("an existing file is replaced, through a link too") {
    const TempFolder folder;
    const std::filesystem::path file = folder.write("tree.bvh", "old");
    std::filesystem::create_symlink(file, folder.path("link.bvh"));
    write_bvh(small_bvh(), folder.path("link.bvh"));
    CHECK(std::filesystem::is_symlink(folder.path("link.bvh")));
    CHECK(same(read_bvh(file), small_bvh()));
    CHECK(folder.entry_count() == 2);
}

TEST_CASE("a target that cannot be written is reported with the system's reason") {
    const TempFolder folder;
    const auto expect = [](const std::filesystem::path& path, const std::string& reason) {
        expect_error(ErrorCode::io, {path.string(), reason}, [&] { write_bvh(small_bvh(), path); });
    };
    std::filesystem::create_directory(folder.path("folder"));
    expect(folder.path("folder"), "Is a directory");
    expect(folder.path("none") / "tree.bvh", "No such file or directory");
    expect(std::filesystem::path(folder.write("file", "")) / "tree.bvh", "Not a directory");
    std::filesystem::create_symlink(folder.path("nowhere"), folder.path("dangling"));
    expect(folder.path("dangling"), "No such file or directory");
    CHECK(folder.entry_count() == 3);
    CHECK(std::filesystem::is_empty(folder.path("folder")));

    if (std::filesystem::is_character_file("/dev/full")) {
        expect("/dev/full", "No space left on device");
        CHECK(std::filesystem::is_character_file("/dev/full"));
    } else {
        WARN("SKIPPED: there is no /dev/full");
    }
}

TEST_CASE("a device is written to, not replaced") {
    if (!std::filesystem::is_character_file("/dev/null")) {
        WARN("SKIPPED: there is no /dev/null");
        return;
    }
    write_bvh(small_bvh(), "/dev/null");
    CHECK(std::filesystem::is_character_file("/dev/null"));
}

TEST_CASE("a file that cannot be finished leaves the old one and nothing else") {
    const TempFolder folder;
    const std::string path = folder.write("tree.bvh", "old");
    Bvh large = small_bvh();
    large.primitive_ids.resize(100000);

    // The process's limit on a file's size stands in for a full disk; without its signal, writes just fail.
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const rlimit tight{50000, before.rlim_max};
    const auto handler = signal(SIGXFSZ, SIG_IGN);
    REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    std::string message;
    try {
        write_bvh(large, path);
    } catch (const Error& error) {
        message = error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, handler);

    CHECK_THAT(message, Catch::Contains(path) && Catch::Contains("File too large"));
    CHECK(content_of(path) == "old");
    CHECK(folder.entry_count() == 1);
}

TEST_CASE("a tree that is not there is reported with the system's reason") {
    const TempFolder folder;
    const std::string path = folder.path("none.bvh").string();
    expect_error(ErrorCode::io, {path, "No such file or directory"}, [&] { (void)read_bvh(path); });
    expect_error(ErrorCode::io, {"Is a directory"}, [&] { (void)read_bvh(folder.path("")); });
}
