// Buffers of all sizes hold what is written, and give their memory back.
#include "device/opencl/device_memory.hpp"

#include <catch2/catch.hpp>
#include <fstream>
#include <numeric>

#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::uint64_t kMiB = 1 << 20;

device::Session& session() {
    return shared_context().session();
}

/// The address space in use, as Linux reports it; 0 elsewhere.
std::uint64_t virtual_bytes() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * 4096;
}

}  // namespace

TEST_CASE("memory: buffers below and above a huge page have their size and keep their bytes") {
    for (const std::uint64_t bytes :
         {std::uint64_t{4}, 4096 * std::uint64_t{1}, 2 * kMiB - 4, 2 * kMiB, 2 * kMiB + 4, 5 * kMiB + 1000}) {
        INFO(bytes);
        const cl::Buffer buffer = device::allocate_buffer(session(), bytes);
        CHECK(buffer.getInfo<CL_MEM_SIZE>() == bytes);
        std::vector<std::uint32_t> values(bytes / 4);
        std::iota(values.begin(), values.end(), 7u);
        write(buffer, values);
        const bool same = read<std::uint32_t>(buffer, values.size()) == values;
        CHECK(same);
    }
}

TEST_CASE("memory: a view keeps the buffer that it was cut from") {
    cl::Buffer buffer = device::allocate_buffer(session(), 8 * kMiB);
    const cl::Buffer view = device::view_of({buffer}, 4096, 4096);
    write(view, std::vector<std::uint32_t>(1024, 42));
    buffer = {};
    CHECK(read<std::uint32_t>(view, 1024) == std::vector<std::uint32_t>(1024, 42));
}

TEST_CASE("memory: released buffers give their memory back, those with views too") {
    if (virtual_bytes() == 0) {
        WARN("SKIPPED: /proc/self/statm tells nothing");
        return;
    }
    (void)device::allocate_buffer(session(), 256 * kMiB);
    const std::uint64_t before = virtual_bytes();
    for (int i = 0; i < 40; ++i) {
        const cl::Buffer buffer = device::allocate_buffer(session(), 256 * kMiB);
        const cl::Buffer view = device::view_of({buffer}, 0, kMiB);
        write(view, std::vector<std::uint32_t>{1});
    }
    CHECK(virtual_bytes() < before + 1024 * kMiB);
}
