// Properties of LBVH: the tree follows from the codes alone, however uneven they are, and wherever the lane shape cuts
// them into pieces.
#include <algorithm>
#include <catch2/catch.hpp>

#include "device/build/cluster_bench.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Codes = std::vector<std::uint64_t>;

constexpr std::uint32_t kPiece = 1024;  // least length of a piece of the lane shape

/// Checks both shapes on `codes`, which are sorted, over boxes of their own.
void expect_prefix_tree(const Codes& codes, const std::string& name) {
    REQUIRE(std::ranges::is_sorted(codes));
    MortonOrder order = order_of_boxes(random_order(codes.size()).bounds);
    order.codes = codes;
    const OracleTree expected = lbvh_tree(order);
    for (const Shape shape : kBothShapes) {
        INFO(to_string(shape) << ", " << codes.size() << " codes: " << name);
        expect_cluster_tree(run_cluster(algorithm_of("lbvh"), options_of(shape), order), expected);
    }
}

/// Codes whose borders lie ever higher up to the middle, then ever lower: none is deeper than both beside it, so that
/// no two of the clusters between them can merge before all are there.
Codes rising_and_falling_borders() {
    Codes codes;
    for (std::uint32_t bit = 0; bit < 63; ++bit)
        codes.push_back(std::uint64_t{1} << bit);
    for (std::uint32_t bit = 62; bit-- > 0;)
        codes.push_back(codes.back() | std::uint64_t{1} << bit);
    return codes;
}

/// `codes` in the middle of as many equal ones before and behind as fill this many pieces.
Codes padded_to_pieces(const Codes& codes, std::uint32_t begin, std::uint32_t pieces) {
    Codes padded(begin, codes.front());
    padded.insert(padded.end(), codes.begin(), codes.end());
    padded.resize(pieces * kPiece, codes.back());
    return padded;
}

}  // namespace

TEST_CASE("lbvh: random codes at sizes around work groups and pieces") {
    for (const std::size_t size : {1u, 2u, 3u, 4u, 5u, 255u, 256u, 257u, 1023u, 1024u, 1025u, 2047u, 2048u, 2049u,
                                   4097u, 32767u, 32768u, 32769u, 70000u}) {
        expect_prefix_tree(random_order(size).codes, "random");
    }
}

TEST_CASE("lbvh: equal codes are told apart by their positions") {
    for (const std::size_t size : {2u, 3u, 1000u, 1024u, 1025u, 5000u})
        expect_prefix_tree(Codes(size, 42), "equal");
    Codes runs;
    for (std::uint32_t i = 0; i < 5000; ++i)
        runs.push_back(i / 37);
    expect_prefix_tree(runs, "runs of equal ones");
}

TEST_CASE("lbvh: one leaf parts from the rest at every bit") {
    Codes chain{0};
    for (std::uint32_t bit = 0; bit < 63; ++bit)
        chain.push_back(std::uint64_t{1} << bit);
    expect_prefix_tree(chain, "the left part is deep");
    Codes mirrored;
    for (const std::uint64_t code : chain)
        mirrored.push_back((std::uint64_t{1} << 63) - 1 - code);
    std::ranges::reverse(mirrored);
    expect_prefix_tree(mirrored, "the right part is deep");
    Codes deepest(4000, 0);
    deepest.insert(deepest.end(), chain.begin(), chain.end());
    deepest.insert(deepest.end(), 4000, chain.back());
    expect_prefix_tree(deepest, "equal codes at both ends");
}

TEST_CASE("lbvh: pieces that leave the most clusters to be joined") {
    const Codes codes = rising_and_falling_borders();
    REQUIRE(codes.size() < kPiece);
    for (const std::uint32_t begin : {0u, 1u, 512u, kPiece - 60, kPiece - 1, kPiece, kPiece + 1, 2 * kPiece - 1}) {
        expect_prefix_tree(padded_to_pieces(codes, begin, 4), "beginning at " + std::to_string(begin));
    }
}

TEST_CASE("lbvh: neighbouring codes that differ in every possible highest bit") {
    Codes codes;
    for (std::uint64_t i = 0; i < 8192; ++i)
        codes.push_back(i << 50 | i << 20 | i);
    expect_prefix_tree(codes, "a full tree");
    for (std::uint64_t& code : codes)
        code |= 1;
    expect_prefix_tree(codes, "pairs of near codes");
}

TEST_CASE("lbvh: small work groups, and as many pieces as a large device takes") {
    const MortonOrder order = random_order(300000);
    const OracleTree expected = lbvh_tree(order);
    for (const Shape shape : kBothShapes) {
        INFO(to_string(shape));
        expect_cluster_tree(run_cluster(algorithm_of("lbvh"), large_device_settings(options_of(shape)), order),
                            expected);
    }
    expect_cluster_tree(run_cluster(algorithm_of("lbvh"), small_group_settings(options_of(Shape::group), 32), order),
                        expected);
}
