// What is special about PLOC++ Two-Level: the ranges that it cuts, and that each is clustered by itself.
#include <algorithm>
#include <catch2/catch.hpp>

#include "device/build/cluster_bench.hpp"
#include "device/build/stage_bench.hpp"
#include "support/builders.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

constexpr std::uint32_t kRadius = 16;

BuildOptions options_with_ranges(Shape shape, std::uint32_t range_count) {
    BuildOptions options = options_of(shape, kRadius);
    options.ploc.range_count = range_count;
    return options;
}

/// Where the ranges begin, and where the last one ends.
using RangeBegins = std::vector<std::uint32_t>;

RangeBegins run_extract_ranges(const BuildOptions& options, const std::vector<std::uint64_t>& codes) {
    StageBench bench(options, codes.size());
    write(bench.buffers.codes, codes);
    const std::uint32_t most = 2 * options.ploc.range_count;
    const std::string defines = bench.settings.search_defines() + " -D MAX_RANGES=" + std::to_string(most);
    device::Kernel& kernel =
        bench.session.kernel("plocpp_two_level.cl", "extract_ranges", bench.settings.cluster_group_size, defines);
    const cl::Buffer begins(bench.session.context(), CL_MEM_READ_WRITE, sizeof(cl_uint) * (most + 1));
    const cl::Buffer total(bench.session.context(), CL_MEM_READ_WRITE, sizeof(cl_uint));
    bench.launcher.launch(kernel, 1, bench.buffers.codes, bench.buffers.leaf_count, options.ploc.range_count, begins,
                          total);
    const std::uint32_t count = bench.launcher.read_uint(total);
    REQUIRE(count <= most);
    return read<std::uint32_t>(begins, count + 1);
}

/// The ranges that rounds of splitting give, where a range splits as its node of the LBVH does.
class RangeSplitter {
public:
    explicit RangeSplitter(const std::vector<std::uint64_t>& codes) : size_(static_cast<std::uint32_t>(codes.size())) {
        MortonOrder order = order_of_boxes(std::vector<Aabb>(codes.size(), Aabb{{0, 0, 0}, {1, 1, 1}}));
        order.codes = codes;
        tree_ = lbvh_tree(order).bvh;
    }

    [[nodiscard]] RangeBegins split(std::uint32_t range_count) const {
        std::vector<Range> ranges{{0, size_, 0}};
        while (ranges.size() < range_count && longest(ranges) > kRadius)
            ranges = split_long_ones(ranges);
        RangeBegins begins;
        for (const Range& range : ranges)
            begins.push_back(range.begin);
        begins.push_back(size_);
        return begins;
    }

private:
    struct Range {
        std::uint32_t begin, end, node;
        [[nodiscard]] std::uint32_t size() const { return end - begin; }
    };

    static std::uint32_t longest(const std::vector<Range>& ranges) {
        return std::ranges::max(ranges, {}, &Range::size).size();
    }

    [[nodiscard]] std::vector<Range> split_long_ones(const std::vector<Range>& ranges) const {
        std::vector<Range> next;
        for (const Range& range : ranges) {
            if (2 * range.size() <= longest(ranges) || range.size() <= kRadius) {
                next.push_back(range);
                continue;
            }
            const std::uint32_t children = tree_.nodes[range.node].first;
            const std::uint32_t middle = children / 2;
            next.push_back({range.begin, middle, children});
            next.push_back({middle, range.end, children + 1});
        }
        return next;
    }

    std::uint32_t size_;
    Bvh tree_;
};

struct NamedCodes {
    std::string name;
    std::vector<std::uint64_t> codes;
};

std::vector<NamedCodes> hard_codes() {
    NamedCodes equal{"equal", std::vector<std::uint64_t>(3000, 7)};
    NamedCodes chain{"a chain", {}};
    for (std::uint32_t i = 0; i < 63 * 40; ++i)
        chain.codes.push_back(std::uint64_t{1} << i / 40);
    NamedCodes uneven{"one apart from the rest", std::vector<std::uint64_t>(2000, 1)};
    uneven.codes.push_back(std::uint64_t{1} << 62);
    return {equal, chain, uneven};
}

void expect_ranges(const NamedCodes& input) {
    const RangeSplitter splitter(input.codes);
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t range_count : {1u, 2u, 7u, 64u, 512u}) {
            INFO(to_string(shape) << ", " << input.codes.size() << " codes, " << input.name << ", at least "
                                  << range_count);
            CHECK(run_extract_ranges(options_with_ranges(shape, range_count), input.codes) ==
                  splitter.split(range_count));
        }
    }
}

}  // namespace

TEST_CASE("plocpp-two-level: ranges are the nodes of the LBVH that rounds of splitting reach") {
    for (const std::size_t size : {1u, 2u, 15u, 16u, 17u, 18u, 33u, 1000u, 20000u})
        expect_ranges({"random", random_order(size).codes});
    for (const NamedCodes& input : hard_codes())
        expect_ranges(input);
}

TEST_CASE("plocpp-two-level: a round of splitting may nearly double the ranges asked for") {
    std::vector<std::uint64_t> codes(65536);
    for (std::uint32_t i = 0; i < codes.size(); ++i)
        codes[i] = std::uint64_t{i} << 40;
    for (const Shape shape : kBothShapes) {
        CHECK(run_extract_ranges(options_with_ranges(shape, 129), codes).size() == 256 + 1);
        CHECK(run_extract_ranges(options_with_ranges(shape, 257), codes).size() == 512 + 1);
        CHECK(run_extract_ranges(options_with_ranges(shape, 512), codes).size() == 512 + 1);
    }
}

TEST_CASE("plocpp-two-level: the tree is the oracle's for every number of ranges") {
    for (const Shape shape : kBothShapes) {
        for (const std::uint32_t size : {1u, 2u, 16u, 17u, 1000u, 10000u}) {
            const MortonOrder order = random_order(size);
            for (const std::uint32_t range_count : {1u, 2u, 7u, 64u, 512u}) {
                INFO(to_string(shape) << ", " << size << ", " << range_count << " ranges");
                const ClusterResult result =
                    run_cluster(algorithm_of("plocpp-two-level"), options_with_ranges(shape, range_count), order);
                const OracleTree expected = two_level_tree(order, kRadius, Comparison::packed, range_count);
                CHECK(result.stats.iterations == 0);
                if (!expect_cluster_tree(result, expected)) return;
            }
        }
    }
}

TEST_CASE("plocpp-two-level: equal boxes on both sides of a range's end do not pair") {
    // Two runs of codes; the boxes beside the border are equal, and nearer to each other than to all others.
    std::vector<Aabb> boxes = widening_points(200);
    boxes[100] = boxes[99];
    MortonOrder order = order_of_boxes(boxes);
    std::fill(order.codes.begin() + 100, order.codes.end(), std::uint64_t{1} << 62);
    const OracleTree together = two_level_tree(order, kRadius, Comparison::packed, 1);
    const OracleTree apart = two_level_tree(order, kRadius, Comparison::packed, 2);
    REQUIRE(together.bvh.nodes[200].first == 99);
    REQUIRE(apart.bvh.nodes[200].first != 99);
    for (const Shape shape : kBothShapes) {
        expect_cluster_tree(run_cluster(algorithm_of("plocpp-two-level"), options_with_ranges(shape, 1), order),
                            together);
        expect_cluster_tree(run_cluster(algorithm_of("plocpp-two-level"), options_with_ranges(shape, 2), order), apart);
    }
}
