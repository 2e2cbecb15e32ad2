// Arrays in one block: what cuts them says how large the block has to be.
#include "device/opencl/memory_block.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "device/opencl/session.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;
using device::ArrayLayout;
using device::Block;

TEST_CASE("array layout: places follow each other, each where one may begin, and the last is not rounded up") {
    ArrayLayout layout({}, 64);
    CHECK(layout.bytes() == 0);
    CHECK(layout.take(1).offset == 0);
    CHECK(layout.bytes() == 1);
    CHECK(layout.take(64).offset == 64);
    CHECK(layout.take(0).offset == 128);
    CHECK(layout.take(65).offset == 128);
    CHECK(layout.bytes() == 193);
    ArrayLayout views;
    views.take(1);
    CHECK(views.take(1).offset == device::kViewAlignment);
}

TEST_CASE("array layout: without a buffer nothing is cut, with one views are where the places are") {
    const auto cut = [](ArrayLayout& layout) {
        return std::array{layout.take_view(100), layout.take_view(0), layout.take_view(5000), layout.take_view(4)};
    };
    ArrayLayout sizes;
    for (const cl::Buffer& view : cut(sizes))
        CHECK(view() == nullptr);
    constexpr std::uint64_t begin = 3 * device::kViewAlignment;
    const cl::Buffer buffer(shared_context().session().context(), CL_MEM_READ_WRITE, begin + sizes.bytes());
    ArrayLayout layout(Block{buffer, begin});
    const auto views = cut(layout);
    CHECK(layout.bytes() == sizes.bytes());
    CHECK(views[1]() == nullptr);
    CHECK(views[0].getInfo<CL_MEM_OFFSET>() == begin);
    CHECK(views[2].getInfo<CL_MEM_OFFSET>() == begin + device::kViewAlignment);
    CHECK(views[2].getInfo<CL_MEM_SIZE>() == 5000);
    CHECK(views[3].getInfo<CL_MEM_OFFSET>() + 4 == begin + sizes.bytes());
    CHECK(views[3].getInfo<CL_MEM_ASSOCIATED_MEMOBJECT>()() == buffer());
}
