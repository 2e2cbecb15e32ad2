// Approximate agglomerative clustering: the tree is what the paper's algorithms say, however the work is done.
#include "host/agglomerative/aac.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>

#include "clbvh/core/validate.hpp"
#include "clbvh/core/vector.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "host/agglomerative/morton.hpp"
#include "support/box_sets.hpp"
#include "support/compare_trees.hpp"
#include "support/expect_error.hpp"
#include "support/oracle/greedy_oracle.hpp"
#include "support/oracle/morton_oracle.hpp"
#include "support/references.hpp"

using namespace clbvh;
using namespace clbvh::test;
using host::aac::Reduction;
using host::aac::Variant;
using simd::InstructionSet;
using simd::kInstructionSets;

namespace {

Reduction reduction_of(const AacConfig& config) {
    return Reduction::of_paper(config.delta, static_cast<double>(config.epsilon));
}

Bvh build_variant(const std::vector<Aabb>& boxes, const AacConfig& config, const Variant& variant) {
    return host::build_over(boxes, [&](host::HostBuild& build) { host::aac::build(build, config, variant); });
}

AacConfig without_flattening(AacConfig config) {
    config.max_leaf_size = 1;
    return config;
}

bool same_tree(const Bvh& a, const Bvh& b) {
    return a.nodes == b.nodes && a.primitive_ids == b.primitive_ids;
}

/// A subtree of the oracle's tree.
struct Subtree {
    Aabb box;
    std::uint32_t position;  ///< The smallest in Morton order.
    std::uint32_t id = 0;    ///< Of a leaf.
    std::vector<Subtree> children;
};

/// Algorithms 2 to 4 of the paper as they stand there, with a search over all pairs for each merge.
class Oracle {
public:
    Oracle(const std::vector<Aabb>& boxes, const AacConfig& config)
        : boxes_(boxes), delta_(config.delta), cubic_cells_(config.cubic_cells), reduction_(reduction_of(config)) {
        bits_ = 3 * host::morton_bits(boxes.size());
        const std::vector<std::uint64_t> codes =
            morton_codes(boxes, config.cubic_cells ? MortonCode::cubic : MortonCode::xyz);
        for (std::uint32_t i = 0; i < boxes.size(); ++i)
            sorted_.push_back({codes[i] >> (63 - bits_), i});
        std::ranges::sort(sorted_);
    }

    [[nodiscard]] Bvh build() {
        std::vector<Subtree> clusters = build_tree(0, static_cast<std::uint32_t>(sorted_.size()), bits_);
        combine(clusters, 1);
        Bvh bvh;
        bvh.nodes.resize(2);
        bvh.primitive_count = boxes_.size();
        write(clusters[0], 0, bvh);
        return bvh;
    }

private:
    /// All codes of begin .. end agree in the bits from `bit` on.
    [[nodiscard]] std::vector<Subtree> build_tree(std::uint32_t begin, std::uint32_t end, std::uint32_t bit) {
        std::vector<Subtree> clusters;
        if (end - begin < delta_) {
            for (std::uint32_t i = begin; i < end; ++i)
                clusters.push_back({boxes_[sorted_[i].second], i, sorted_[i].second, {}});
            combine(clusters, reduction_(delta_));
            return clusters;
        }
        std::uint32_t split = begin + (end - begin) / 2;
        if (bit == 0 && cubic_cells_ && end - begin > 32) bit = recode(begin, end);
        if (bit > 0) {
            --bit;
            split = begin;
            while (split < end && (sorted_[split].first >> bit & 1) == 0)
                ++split;
            if (split == begin || split == end) return build_tree(begin, end, bit);
        }
        clusters = build_tree(begin, split, bit);
        std::ranges::move(build_tree(split, end, bit), std::back_inserter(clusters));
        combine(clusters, reduction_(end - begin));
        return clusters;
    }

    /// Codes within the bounds of begin .. end, which had one code. Returns their bits; 0 where all are in one place.
    std::uint32_t recode(std::uint32_t begin, std::uint32_t end) {
        std::vector<Aabb> boxes;
        for (std::uint32_t i = begin; i < end; ++i)
            boxes.push_back(boxes_[sorted_[i].second]);
        const Aabb centroids = scene_bounds(boxes).doubled_centroids;
        if (length(centroids.upper - centroids.lower) == 0) return 0;
        const std::vector<std::uint64_t> codes = morton_codes(boxes, MortonCode::cubic);
        for (std::uint32_t i = begin; i < end; ++i)
            sorted_[i].first = codes[i - begin];
        std::sort(sorted_.begin() + begin, sorted_.begin() + end);
        return 63;
    }

    static void combine(std::vector<Subtree>& clusters, std::uint32_t target) {
        while (clusters.size() > target) {
            std::size_t left = 0, right = 0;
            float best = std::numeric_limits<float>::infinity();
            for (std::size_t i = 0; i < clusters.size(); ++i) {
                for (std::size_t j = i + 1; j < clusters.size(); ++j) {
                    const float distance = half_area(merge(clusters[i].box, clusters[j].box));
                    if (distance >= best) continue;
                    best = distance;
                    left = i;
                    right = j;
                }
            }
            if (clusters[right].position < clusters[left].position) std::swap(clusters[left], clusters[right]);
            Subtree merged{merge(clusters[left].box, clusters[right].box), clusters[left].position, 0, {}};
            merged.children.push_back(std::move(clusters[left]));
            merged.children.push_back(std::move(clusters[right]));
            clusters[left] = std::move(merged);
            clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(right));
        }
    }

    static void write(const Subtree& subtree, std::size_t slot, Bvh& bvh) {
        const Aabb& box = subtree.box;
        const bool is_leaf = subtree.children.empty();
        const auto first = static_cast<std::uint32_t>(is_leaf ? bvh.primitive_ids.size() : bvh.nodes.size());
        bvh.nodes[slot] = {
            {box.lower.x, box.lower.y, box.lower.z}, first, {box.upper.x, box.upper.y, box.upper.z}, is_leaf ? 1u : 0u};
        if (is_leaf) return bvh.primitive_ids.push_back(subtree.id);
        bvh.nodes.resize(bvh.nodes.size() + 2);
        write(subtree.children[0], first, bvh);
        write(subtree.children[1], first + 1, bvh);
    }

    const std::vector<Aabb>& boxes_;
    std::uint32_t delta_;
    bool cubic_cells_;
    Reduction reduction_;
    std::uint32_t bits_ = 0;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted_;
};

/// Flattens a tree of one-primitive leaves as section 3.3.2 says, from the finished tree.
class Flattener {
public:
    Flattener(const Bvh& bvh, const AacConfig& config) : bvh_(bvh), config_(config) {}

    [[nodiscard]] Bvh run() {
        Bvh result;
        result.nodes.resize(2);
        result.primitive_count = bvh_.primitive_count;
        write(0, 0, result);
        return result;
    }

private:
    struct Cost {
        float cost;
        bool is_leaf;
        std::vector<std::uint32_t> ids;
    };

    [[nodiscard]] Cost cost_of(std::uint32_t index) const {
        const Node& node = bvh_.nodes[index];
        if (node.is_leaf()) return {config_.primitive_cost, true, {bvh_.primitive_ids[node.first]}};
        Cost left = cost_of(node.first);
        const Cost right = cost_of(node.first + 1);
        left.ids.insert(left.ids.end(), right.ids.begin(), right.ids.end());
        const float area = half_area(node.bounds());
        const float left_cost = config_.inner_cost + left.cost;
        const float right_cost = config_.inner_cost + right.cost;
        const float as_inner = area > 0 ? (half_area(bvh_.nodes[node.first].bounds()) * left_cost +
                                           half_area(bvh_.nodes[node.first + 1].bounds()) * right_cost) /
                                              area
                                        : left_cost + right_cost;
        const float as_leaf = config_.primitive_cost * static_cast<float>(left.ids.size());
        const bool is_leaf = as_leaf <= as_inner && left.ids.size() <= config_.max_leaf_size;
        std::ranges::sort(left.ids);
        return {std::min(as_leaf, as_inner), is_leaf, left.ids};
    }

    void write(std::uint32_t from, std::size_t to, Bvh& result) const {
        Node node = bvh_.nodes[from];
        const Cost cost = cost_of(from);
        if (cost.is_leaf) {
            node.first = static_cast<std::uint32_t>(result.primitive_ids.size());
            node.count = static_cast<std::uint32_t>(cost.ids.size());
            result.primitive_ids.insert(result.primitive_ids.end(), cost.ids.begin(), cost.ids.end());
            result.nodes[to] = node;
            return;
        }
        const std::uint32_t children = node.first;
        node.first = static_cast<std::uint32_t>(result.nodes.size());
        result.nodes[to] = node;
        result.nodes.resize(result.nodes.size() + 2);
        write(children, node.first, result);
        write(children + 1, node.first + 1, result);
    }

    const Bvh& bvh_;
    const AacConfig& config_;
};

void expect_flattened(const std::vector<Aabb>& boxes, const AacConfig& config) {
    const Bvh whole = build_aac(boxes, without_flattening(config));
    const Bvh flattened = build_aac(boxes, config);
    CHECK(compare_trees(flattened, Flattener(whole, config).run()) == "");
}

}  // namespace

TEST_CASE("AAC is what the paper's algorithms say", "[host][aac]") {
    for (const AacConfig& preset : {AacConfig::hq(), AacConfig::fast()}) {
        const AacConfig config = without_flattening(preset);
        for (const std::size_t count : {1u, 2u, 3u, 4u, 5u, 19u, 20u, 21u, 64u, 333u, 1000u, 9000u}) {
            INFO("delta " << config.delta << ", " << count << " boxes");
            const std::vector<Aabb> boxes = random_boxes(count);
            CHECK(compare_trees(build_aac(boxes, config), Oracle(boxes, config).build()) == "");
        }
        // Clusters of all sizes, and more codes than there are bits for.
        const std::vector<Aabb> boxes = boxes_of(generate_scene("clustered", 6000));
        CHECK(compare_trees(build_aac(boxes, config), Oracle(boxes, config).build()) == "");
    }
}

TEST_CASE("AAC without reduction is greedy agglomerative clustering", "[host][aac]") {
    const AacConfig config = without_flattening(AacConfig::hq());
    for (const InstructionSet set : kInstructionSets) {
        if (!is_available(set)) continue;
        const Variant variant{Reduction::none(), set};
        for (const std::size_t count : {1u, 2u, 3u, 8u, 9u, 50u, 1000u}) {
            INFO(count << " boxes, instruction set " << static_cast<int>(set));
            for (const std::vector<Aabb>& boxes : {random_boxes(count), grid_boxes(count)})
                CHECK(check_greedy(build_variant(boxes, config, variant), boxes) == "");
        }
    }
}

TEST_CASE("AAC without reduction is greedy where several tasks meet", "[host][aac]") {
    const std::vector<Aabb> boxes = random_boxes(4500);
    const Bvh bvh = build_variant(boxes, without_flattening(AacConfig::fast()), {Reduction::none()});
    CHECK(check_greedy(bvh, boxes) == "");
}

TEST_CASE("AAC gives the same tree with any vectors", "[host][aac]") {
    std::vector<BoxSet> sets = hard_box_sets(3000);
    sets.push_back({"random boxes", random_boxes(20'000)});
    sets.push_back({"boxes on a grid", grid_boxes(20'000)});
    for (const BoxSet& set : sets) {
        for (const AacConfig& config : {AacConfig::hq(), AacConfig::fast()}) {
            const Bvh expected = build_variant(set.boxes, config, {reduction_of(config), InstructionSet::scalar});
            for (const InstructionSet instructions : kInstructionSets) {
                if (!is_available(instructions)) continue;
                INFO(set.name << ", delta " << config.delta << ", instruction set " << static_cast<int>(instructions));
                CHECK(same_tree(expected, build_variant(set.boxes, config, {reduction_of(config), instructions})));
            }
        }
    }
}

TEST_CASE("AAC gives the same bytes on one thread", "[host][aac]") {
    for (const std::string_view scene : {"soup", "clustered", "hair"}) {
        const std::vector<Aabb> boxes = boxes_of(generate_scene(scene, 60'000));
        for (const AacConfig& config : {AacConfig::hq(), AacConfig::fast()}) {
            INFO(scene << ", delta " << config.delta);
            Bvh alone;
            tbb::task_arena(1).execute([&] { alone = build_aac(boxes, config); });
            CHECK(same_tree(alone, build_aac(boxes, config)));
        }
    }
}

TEST_CASE("AAC flattens where the paper's cost says so", "[host][aac]") {
    for (AacConfig config : {AacConfig::hq(), AacConfig::fast()}) {
        for (const std::uint32_t max_leaf_size : {2u, 8u, 64u}) {
            config.max_leaf_size = max_leaf_size;
            INFO("delta " << config.delta << ", leaves of up to " << max_leaf_size);
            expect_flattened(random_boxes(1500), config);
            expect_flattened(grid_boxes(1500), config);
            expect_flattened(boxes_of(generate_scene("clustered", 1500)), config);
        }
    }
    AacConfig config = AacConfig::hq();
    config.inner_cost = 0.3f;
    config.primitive_cost = 2.0f;
    expect_flattened(grid_boxes(1500), config);
    expect_flattened(std::vector<Aabb>(100, Aabb{{1, 1, 1}, {1, 1, 1}}), config);
}

TEST_CASE("AAC builds valid trees over the hardest boxes", "[host][aac]") {
    for (const std::size_t count : {1u, 2u, 3u, 5u, 16u, 400u, 100'000u}) {
        for (const BoxSet& set : hard_box_sets(count)) {
            const Mesh mesh = mesh_of_boxes(set.boxes);
            for (const AacConfig& config : {AacConfig::hq(), AacConfig::fast()}) {
                INFO(set.name << ", " << count << ", delta " << config.delta);
                CHECK(validate(build_aac(set.boxes, config), mesh).error == "");
            }
        }
    }
}

TEST_CASE("AAC makes no deep tree of equal boxes", "[host][aac]") {
    const std::vector<Aabb> boxes(100'000, Aabb{{0, 0, 0}, {0.1f, 0.2f, 0.3f}});
    const Mesh mesh = mesh_of_boxes(boxes);
    for (const AacConfig& config : {AacConfig::hq(), AacConfig::fast()})
        CHECK(validate(build_aac(boxes, without_flattening(config)), mesh).depth <= 40);
}

TEST_CASE("the reduction of AAC is the paper's", "[host][aac]") {
    for (const std::uint32_t delta : {2u, 4u, 20u, 64u}) {
        for (const double epsilon : {0.0, 0.1, 0.2, 0.5}) {
            const Reduction reduction = Reduction::of_paper(delta, epsilon);
            CHECK(reduction(delta) == delta / 2);
            CHECK(reduction(1) == 1);
            const host::aac::ReductionTable table(reduction, 3000);
            for (std::size_t n = 1; n <= 3000; ++n) {
                if (table(n) != reduction(n)) FAIL("delta " << delta << ", epsilon " << epsilon << ", n " << n);
            }
        }
    }
    CHECK(Reduction::none()(12345) == 12345);
    // Section 3.4: at the root of San Miguel, 7.9 M triangles, about 1,724 clusters meet under AAC-HQ.
    const Reduction hq = reduction_of(AacConfig::hq());
    CHECK(2 * hq(7'900'000 / 2) > 1'724);
    CHECK(hq(7'900'000) < 1'800);
}

TEST_CASE("ranges are parted where the highest differing bit of the code becomes 1", "[host][aac]") {
    const std::vector<std::uint64_t> codes{0, 0, 1, 4, 5, 5, 5, 5, 5, 9, 12, 12, 31};
    const auto part = [&](std::uint32_t begin, std::uint32_t end) {
        return host::aac::partition(codes.data(), begin, end);
    };
    CHECK(part(0, 13) == 12);
    CHECK(part(0, 12) == 9);
    CHECK(part(0, 9) == 3);
    CHECK(part(0, 3) == 2);
    CHECK(part(9, 12) == 10);
    CHECK(part(4, 9) == 6);
    CHECK(part(4, 6) == 5);
}

TEST_CASE("host Morton codes interleave the cells of the centroid", "[host][aac]") {
    CHECK(host::morton_bits(1) == 1);
    CHECK(host::morton_bits(4) == 1);
    CHECK(host::morton_bits(5) == 2);
    CHECK(host::morton_bits(16) == 2);
    CHECK(host::morton_bits(1u << 20) == 10);
    CHECK(host::morton_bits((1u << 20) + 1) == 11);
    CHECK(host::morton_bits((std::size_t{1} << 30) - 1) == 15);
    for (const std::uint32_t bits : {1u, 7u, 10u}) {
        const float cells = static_cast<float>(1u << bits);
        const Box4 bounds{Float4::filled(0.0f), Float4::of(cells, cells, cells)};
        const host::MortonGrid grid = host::MortonGrid::stretched(bounds, bits);
        for (std::uint32_t i = 0; i < 200; ++i) {
            const std::uint32_t cell[3] = {i * 7919 % (1u << bits), i * 104729 % (1u << bits), i * 31 % (1u << bits)};
            std::uint64_t expected = 0;
            for (std::uint32_t bit = bits; bit-- > 0;)
                for (const std::uint32_t c : cell)
                    expected = expected << 1 | (c >> bit & 1);
            const auto at = [&](std::size_t axis) { return static_cast<float>(cell[axis]) / 2 + 0.25f; };
            const host::Reference reference{{at(0), at(1), at(2)}, i, {at(0), at(1), at(2)}, 0};
            REQUIRE(grid.code_of(reference) == expected);
        }
    }
}

TEST_CASE("host Morton codes halve the longest axis, bit by bit as the oracle has it", "[host][aac]") {
    const std::vector<Vec3> extents{{1, 1, 1}, {8, 2, 1},       {1, 3, 7},      {5, 5, 0},     {0, 0, 2},
                                    {0, 0, 0}, {1e6f, 1, 1e3f}, {1, 1e-30f, 1}, {9e17f, 1, 1}, {3, 2.9f, 1.5f}};
    for (const Vec3& extent : extents) {
        std::vector<Aabb> boxes = random_boxes(500);
        std::vector<host::Reference> references;
        for (Aabb& box : boxes) {
            const Vec3 at = box.lower;
            const Vec3 corner{at.x * extent.x, at.y * extent.y, at.z * extent.z};
            box = {corner, corner};
            references.push_back(host::make_reference(box, 0));
        }
        const std::vector<std::uint64_t> expected = morton_codes(boxes, MortonCode::cubic);
        for (const std::uint32_t bits : {3u, 30u, 42u, 63u}) {
            const host::MortonGrid grid = host::MortonGrid::cubic(centroid_bounds_of(references), bits);
            for (std::size_t i = 0; i < boxes.size(); ++i)
                REQUIRE(grid.code_of(references[i]) == expected[i] >> (63 - bits));
        }
    }
}

TEST_CASE("AAC equals the oracle where a far box leaves all others in one cell, and again among these", "[host][aac]") {
    for (const float distance : {1e3f, 1e6f, 1e12f}) {
        std::vector<Aabb> boxes = random_boxes(300);
        const Vec3 far{distance, -distance, distance};
        boxes.push_back({far, far});
        const Vec3 farther{distance * distance, 0, 0};
        if (distance < 1e9f) boxes.push_back({farther, farther});
        for (const bool cubic : {true, false}) {
            AacConfig config = without_flattening(AacConfig::fast());
            config.cubic_cells = cubic;
            INFO(distance << (cubic ? ", cubic" : ", stretched"));
            const Bvh bvh = build_variant(boxes, config, {.reduction = reduction_of(config)});
            CHECK(compare_trees(bvh, Oracle(boxes, config).build()) == "");
        }
    }
}

TEST_CASE("AAC refuses what is out of range, naming it", "[host][aac]") {
    const std::vector<Aabb> boxes = random_boxes(10);
    const auto expect_refused = [&](const std::string& field, const auto& change) {
        AacConfig config;
        change(config);
        expect_error(ErrorCode::invalid_input, {field + " is"}, [&] { static_cast<void>(build_aac(boxes, config)); });
    };
    expect_refused("delta", [](AacConfig& c) { c.delta = 1; });
    expect_refused("delta", [](AacConfig& c) { c.delta = 65; });
    expect_refused("epsilon", [](AacConfig& c) { c.epsilon = -0.1f; });
    expect_refused("epsilon", [](AacConfig& c) { c.epsilon = 0.6f; });
    expect_refused("epsilon", [](AacConfig& c) { c.epsilon = std::numeric_limits<float>::quiet_NaN(); });
    expect_refused("inner_cost", [](AacConfig& c) { c.inner_cost = 0; });
    expect_refused("primitive_cost", [](AacConfig& c) { c.primitive_cost = -1; });
    expect_refused("max_leaf_size", [](AacConfig& c) { c.max_leaf_size = 0; });
    expect_refused("max_leaf_size", [](AacConfig& c) { c.max_leaf_size = 65; });
    CHECK(build_aac({}).empty());
}

TEST_CASE("AAC builds over every legal delta and epsilon", "[host][aac]") {
    const std::vector<Aabb> boxes = boxes_of(generate_scene("clustered", 6000));
    const Mesh mesh = mesh_of_boxes(boxes);
    for (const std::uint32_t delta : {2u, 3u, 9u, 64u}) {
        for (const float epsilon : {0.0f, 0.5f}) {
            INFO("delta " << delta << ", epsilon " << epsilon);
            AacConfig config;
            config.delta = delta;
            config.epsilon = epsilon;
            CHECK(validate(build_aac(boxes, config), mesh).error == "");
        }
    }
}
