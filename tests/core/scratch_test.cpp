// Scratch memory: arrays do not overlap, memory stays for the next build, and what was taken is counted.
#include "core/scratch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <thread>
#include <vector>

#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

TEST_CASE("scratch arrays are aligned and apart") {
    Scratch scratch;
    std::vector<std::span<std::uint32_t>> arrays;
    for (const std::size_t count : {1u, 7u, 1000u, 3000000u, 0u, 5u, 600000u})
        arrays.push_back(scratch.take<std::uint32_t>(count));
    for (std::size_t a = 0; a < arrays.size(); ++a) {
        CHECK(reinterpret_cast<std::uintptr_t>(arrays[a].data()) % 64 == 0);
        for (std::uint32_t& value : arrays[a])
            value = static_cast<std::uint32_t>(a);
    }
    for (std::size_t a = 0; a < arrays.size(); ++a) {
        for (const std::uint32_t value : arrays[a])
            REQUIRE(value == a);
    }
}

TEST_CASE("scratch counts what is in use, in steps of its alignment") {
    Scratch scratch;
    CHECK(scratch.bytes_in_use() == 0);
    static_cast<void>(scratch.take<char>(1));
    CHECK(scratch.bytes_in_use() == 64);
    static_cast<void>(scratch.take<double>(8000000));
    CHECK(scratch.bytes_in_use() == 64 + 64000000);
    scratch.reset();
    CHECK(scratch.bytes_in_use() == 0);
}

TEST_CASE("scratch gives the same memory to the next build of the same size") {
    Scratch scratch;
    const auto take_all = [&] {
        scratch.reset();
        const auto a = scratch.take<std::uint64_t>(1000000);
        const auto b = scratch.take<std::uint64_t>(2000000);
        return std::pair(a.data(), b.data());
    };
    take_all();
    const auto second = take_all();  // now in one block
    CHECK(take_all() == second);
    CHECK(second.second == second.first + 1000000);
}

TEST_CASE("scratch serves many threads") {
    Scratch scratch;
    std::vector<std::span<int>> arrays(8);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < arrays.size(); ++t) {
        threads.emplace_back([&, t] {
            for (int i = 0; i < 100; ++i)
                arrays[t] = scratch.take<int>(1000);
            for (int& value : arrays[t])
                value = static_cast<int>(t);
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    for (std::size_t t = 0; t < arrays.size(); ++t)
        CHECK(std::ranges::all_of(arrays[t], [&](int value) { return value == static_cast<int>(t); }));
    CHECK(scratch.bytes_in_use() == 8u * 100u * 4032u);
}

TEST_CASE("scratch that the system cannot give is an Error, and the rest stays usable") {
    Scratch scratch;
    const auto before = scratch.take<int>(100);
    expect_error(ErrorCode::out_of_memory, {"MiB"},
                 [&] { static_cast<void>(scratch.take<std::uint64_t>(std::uint64_t{1} << 50)); });
    const auto after = scratch.take<int>(100);
    CHECK(after.data() != before.data());
    CHECK(scratch.bytes_in_use() == 2 * 448);
}
