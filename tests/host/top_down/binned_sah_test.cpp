// Binned SAH against a second implementation: plain recursion over vectors of boxes, every border of every bin tried by
// merging all boxes again. Same bins, same costs, same ties, so the trees must be equal to the bit.
#include "clbvh/host/binned_sah.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "support/compare_trees.hpp"
#include "support/expect_error.hpp"
#include "support/instruction_sets.hpp"
#include "support/meshes.hpp"
#include "support/references.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

std::array<float, 3> lanes(const Vec3& v) {
    return {v.x, v.y, v.z};
}

class Oracle {
public:
    Oracle(const std::vector<Aabb>& boxes, const BinnedSahConfig& config) : boxes_(boxes), config_(config) {}

    Bvh build() {
        bvh_.primitive_count = boxes_.size();
        if (boxes_.empty()) return bvh_;
        bvh_.nodes.resize(2);
        std::vector<std::uint32_t> all(boxes_.size());
        for (std::uint32_t i = 0; i < all.size(); ++i)
            all[i] = i;
        build_node(0, all);
        return bvh_;
    }

private:
    using Ids = std::vector<std::uint32_t>;
    struct Split {
        float cost = std::numeric_limits<float>::infinity();
        Ids left, right;
    };

    Aabb bounds(const Ids& ids) const {
        Aabb box;
        for (const std::uint32_t id : ids)
            box = merge(box, boxes_[id]);
        return box;
    }

    Aabb centroid_bounds(const Ids& ids) const {
        Aabb box;
        for (const std::uint32_t id : ids)
            box = merge(box, doubled_centroid(boxes_[id]));
        return box;
    }

    Split find_split(const Ids& ids) const {
        const Aabb centroids = centroid_bounds(ids);
        const auto lower = lanes(centroids.lower);
        std::array<float, 3> extent;
        for (std::size_t axis = 0; axis < 3; ++axis)
            extent[axis] = lanes(centroids.upper)[axis] - lower[axis];
        const auto longest = static_cast<std::size_t>(std::ranges::max_element(extent) - extent.begin());
        Split best;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (extent[axis] <= 0.0f || (config_.longest_axis_only && axis != longest)) continue;
            const float scale = static_cast<float>(config_.bin_count) / extent[axis];
            const auto bin_of = [&](std::uint32_t id) {
                const float bin = (lanes(doubled_centroid(boxes_[id]))[axis] - lower[axis]) * scale;
                return static_cast<std::uint32_t>(std::min(bin, static_cast<float>(config_.bin_count - 1)));
            };
            for (std::uint32_t border = 1; border < config_.bin_count; ++border)
                try_border(
                    ids, [&](std::uint32_t id) { return bin_of(id) < border; }, best);
        }
        return best;
    }

    template <typename IsLeft>
    void try_border(const Ids& ids, const IsLeft& is_left, Split& best) const {
        Split split;
        std::ranges::partition_copy(ids, std::back_inserter(split.left), std::back_inserter(split.right), is_left);
        if (split.left.empty() || split.right.empty()) return;
        split.cost = half_area(bounds(split.left)) * static_cast<float>(split.left.size()) +
                     half_area(bounds(split.right)) * static_cast<float>(split.right.size());
        if (split.cost < best.cost) best = split;
    }

    void build_node(std::size_t node, const Ids& ids) {
        const Aabb box = bounds(ids);
        Split split = find_split(ids);
        const float area = half_area(box);
        const float leaf_cost = config_.primitive_cost * static_cast<float>(ids.size()) * area;
        const float split_cost = config_.inner_cost * area + config_.primitive_cost * split.cost;
        if (ids.size() == 1 || (ids.size() <= config_.max_leaf_size && leaf_cost <= split_cost)) {
            set(node, box, bvh_.primitive_ids.size(), ids.size());
            bvh_.primitive_ids.insert(bvh_.primitive_ids.end(), ids.begin(), ids.end());
            return;
        }
        if (split.left.empty()) {
            const auto half = ids.begin() + static_cast<std::ptrdiff_t>(ids.size() / 2);
            split.left.assign(ids.begin(), half);
            split.right.assign(half, ids.end());
        }
        const std::size_t children = bvh_.nodes.size();
        bvh_.nodes.resize(children + 2);
        set(node, box, children, 0);
        build_node(children, split.left);
        build_node(children + 1, split.right);
    }

    void set(std::size_t node, const Aabb& box, std::size_t first, std::size_t count) {
        bvh_.nodes[node] = {{box.lower.x, box.lower.y, box.lower.z},
                            static_cast<std::uint32_t>(first),
                            {box.upper.x, box.upper.y, box.upper.z},
                            static_cast<std::uint32_t>(count)};
    }

    const std::vector<Aabb>& boxes_;
    BinnedSahConfig config_;
    Bvh bvh_;
};

void expect_oracle_tree(const Mesh& mesh, const BinnedSahConfig& config, const std::string& where) {
    INFO(where);
    const std::vector<Aabb> boxes = boxes_of(mesh);
    const Bvh bvh = build_binned_sah(boxes, config);
    CHECK(compare_trees(Oracle(boxes, config).build(), bvh) == "");
    CHECK(validate(bvh, mesh).error == "");
}

}  // namespace

TEST_CASE("binned-sah equals its oracle on every generated scene") {
    with_each_instruction_set([] {
        for (const SceneGeneratorInfo& scene : scene_generators()) {
            for (const std::uint32_t size : {1u, 2u, 3u, 5u, 8u, 9u, 16u, 17u, 18u, 33u, 100u, 1000u})
                expect_oracle_tree(generate_scene(scene.name, size), {}, std::string(scene.name));
        }
    });
}

TEST_CASE("binned-sah equals its oracle with other options") {
    const Mesh mesh = generate_scene("clustered", 1500);
    for (const std::uint32_t bins : {2u, 3u, 15u, 32u, 33u, 63u, 64u}) {
        BinnedSahConfig config;
        config.bin_count = bins;
        expect_oracle_tree(mesh, config, std::to_string(bins) + " bins");
    }
    for (const std::uint32_t leaf : {1u, 2u, 64u}) {
        BinnedSahConfig config;
        config.max_leaf_size = leaf;
        expect_oracle_tree(mesh, config, "leaves of " + std::to_string(leaf));
    }
    BinnedSahConfig longest;
    longest.longest_axis_only = true;
    expect_oracle_tree(mesh, longest, "longest axis");
    BinnedSahConfig costs;
    costs.inner_cost = 3.0f;
    costs.primitive_cost = 0.5f;
    expect_oracle_tree(mesh, costs, "other costs");
}

TEST_CASE("binned-sah equals its oracle where ranges are divided in parallel") {
    // Above the 65,536 references from which chunks are binned apart.
    with_each_instruction_set([] { expect_oracle_tree(generate_scene("soup", 70000), {}, "soup"); });
    expect_oracle_tree(generate_scene("particles", 70000), {}, "particles");
}

TEST_CASE("binned-sah halves what no bin can tell apart") {
    const std::vector<Aabb> boxes(1000, Aabb{{1, 2, 3}, {4, 5, 6}});
    const Bvh bvh = build_binned_sah(boxes);
    for (const Node& node : bvh.nodes)
        CHECK(node.count <= 8);
    CHECK(std::ranges::is_sorted(bvh.primitive_ids));
    CHECK(compare_trees(Oracle(boxes, {}).build(), bvh) == "");
}

TEST_CASE("binned-sah keeps its depth where every split takes one box away") {
    // Each box is far larger than all before it together: every split takes one away.
    std::vector<Aabb> boxes;
    for (int i = 0; i < 600; ++i) {
        const float size = std::ldexp(1.0f, i % 150 - 100);
        boxes.push_back({{0, 0, 0}, {size, i < 150 ? size : 0.0f, i < 300 ? size : 0.0f}});
    }
    BinnedSahConfig config;
    config.max_leaf_size = 1;
    config.bin_count = 2;
    const Bvh bvh = build_binned_sah(boxes, config);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> open{{0, 0}};
    std::uint32_t depth = 0;
    while (!open.empty()) {
        const auto [index, level] = open.back();
        open.pop_back();
        depth = std::max(depth, level);
        if (bvh.nodes[index].is_leaf()) continue;
        open.push_back({bvh.nodes[index].first, level + 1});
        open.push_back({bvh.nodes[index].first + 1, level + 1});
    }
    CHECK(depth > 64);
    CHECK(depth <= 288);
}

TEST_CASE("binned-sah builds the same tree where costs would overflow") {
    const Mesh mesh = generate_scene("clustered", 20000);
    const Bvh small = build_binned_sah(boxes_of(scaled(mesh, 0x1p-3f)));
    const Bvh large = build_binned_sah(boxes_of(scaled(mesh, largest_scale(mesh))));
    CHECK(same_topology(large, small));
}

TEST_CASE("more bins make better trees, one axis worse ones") {
    const std::vector<Aabb> boxes = boxes_of(generate_scene("city", 20000));
    BinnedSahConfig few, longest;
    few.bin_count = 3;
    longest.longest_axis_only = true;
    const double cost = sah_cost(build_binned_sah(boxes));
    CHECK(cost < sah_cost(build_binned_sah(boxes, few)));
    CHECK(cost < sah_cost(build_binned_sah(boxes, longest)));
}

TEST_CASE("binned-sah names what is wrong with its input") {
    const std::vector<Aabb> boxes{{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 2}, {1, 1, 1}}};
    expect_error(ErrorCode::invalid_input, {"box 1"}, [&] { static_cast<void>(build_binned_sah(boxes)); });
    const auto expect_rejected = [](const BinnedSahConfig& config, const std::string& field, const std::string& range) {
        expect_error(ErrorCode::invalid_input, {field, range},
                     [&] { static_cast<void>(build_binned_sah({}, config)); });
    };
    BinnedSahConfig config;
    config.bin_count = 65;
    expect_rejected(config, "bin_count is 65", "2 to 64");
    config = {};
    config.inner_cost = 0.0f;
    expect_rejected(config, "inner_cost is 0", "above 0");
    config = {};
    config.primitive_cost = std::numeric_limits<float>::quiet_NaN();
    expect_rejected(config, "primitive_cost is nan", "above 0");
    config = {};
    config.max_leaf_size = 0;
    expect_rejected(config, "max_leaf_size is 0", "1 to 64");
}
