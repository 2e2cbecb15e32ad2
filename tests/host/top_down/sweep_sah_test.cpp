#include "clbvh/host/sweep_sah.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "clbvh/core/validate.hpp"
#include "support/box_sets.hpp"
#include "support/compare_trees.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

using Ids = std::vector<std::uint32_t>;

/// Sweep SAH as the definition says: at each node every position along every axis, sorted afresh, is evaluated.
class SweepOracle {
public:
    SweepOracle(const std::vector<Aabb>& boxes, const SweepSahConfig& config) : boxes_(boxes), config_(config) {}

    Bvh build() {
        Ids ids(boxes_.size());
        std::iota(ids.begin(), ids.end(), 0u);
        tree_.primitive_count = boxes_.size();
        tree_.nodes.resize(2);
        build_node(0, ids);
        return std::move(tree_);
    }

private:
    struct Split {
        float cost;
        std::uint64_t imbalance;
        std::size_t axis;
        std::size_t position;

        friend auto operator<=>(const Split&, const Split&) = default;
    };

    Ids sorted(Ids ids, std::size_t axis) const {
        std::ranges::sort(ids, {}, [&](std::uint32_t id) {
            const Vec3 centroid = doubled_centroid(boxes_[id]);
            return std::tuple(axis == 0 ? centroid.x : axis == 1 ? centroid.y : centroid.z, id);
        });
        return ids;
    }

    /// half area of ids[0 .. i] for each i.
    template <typename Range>
    std::vector<float> half_areas(const Range& ids) const {
        std::vector<float> areas;
        Aabb box;
        for (const std::uint32_t id : ids)
            areas.push_back(half_area(box = merge(box, boxes_[id])));
        return areas;
    }

    Split find_split(const Ids& ids) const {
        const std::size_t count = ids.size();
        std::vector<Split> splits;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Ids order = sorted(ids, axis);
            const std::vector<float> left = half_areas(order);
            std::ranges::reverse(order);
            const std::vector<float> right = half_areas(order);
            for (std::size_t p = 1; p < count; ++p) {
                const float cost =
                    left[p - 1] * static_cast<float>(p) + right[count - p - 1] * static_cast<float>(count - p);
                splits.push_back({cost, 2 * p > count ? 2 * p - count : count - 2 * p, axis, p});
            }
        }
        return *std::min_element(splits.begin(), splits.end());
    }

    void build_node(std::size_t slot, const Ids& ids) {
        Aabb box;
        for (const std::uint32_t id : ids)
            box = merge(box, boxes_[id]);
        const float count = static_cast<float>(ids.size());
        const float area = half_area(box);
        const Split split = ids.size() == 1 ? Split{} : find_split(ids);
        const bool is_worth =
            config_.inner_cost * area + config_.primitive_cost * split.cost < config_.primitive_cost * count * area;
        Node node{{box.lower.x, box.lower.y, box.lower.z}, 0, {box.upper.x, box.upper.y, box.upper.z}, 0};
        if (ids.size() == 1 || (ids.size() <= config_.max_leaf_size && !is_worth)) {
            node.first = static_cast<std::uint32_t>(tree_.primitive_ids.size());
            node.count = static_cast<std::uint32_t>(ids.size());
            tree_.nodes[slot] = node;
            tree_.primitive_ids.insert(tree_.primitive_ids.end(), ids.begin(), ids.end());
            std::sort(tree_.primitive_ids.begin() + node.first, tree_.primitive_ids.end());
            return;
        }
        node.first = static_cast<std::uint32_t>(tree_.nodes.size());
        tree_.nodes[slot] = node;
        tree_.nodes.resize(tree_.nodes.size() + 2);
        const Ids order = sorted(ids, split.axis);
        const auto border = order.begin() + static_cast<std::ptrdiff_t>(split.position);
        build_node(node.first, Ids(order.begin(), border));
        build_node(node.first + 1, Ids(border, order.end()));
    }

    const std::vector<Aabb>& boxes_;
    SweepSahConfig config_;
    Bvh tree_;
};

void expect_oracle_tree(const std::vector<Aabb>& boxes, const SweepSahConfig& config, const std::string& where) {
    INFO(where << ", " << boxes.size() << " boxes");
    const Bvh expected = SweepOracle(boxes, config).build();
    CHECK(compare_trees(build_sweep_sah(boxes, config), expected) == "");
}

Bvh build_on_threads(int threads, const std::vector<Aabb>& boxes) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] { return build_sweep_sah(boxes); });
}

}  // namespace

TEST_CASE("sweep SAH takes the best of all splits at every node", "[host][sweep_sah]") {
    for (std::uint32_t count = 1; count <= 100; ++count) {
        expect_oracle_tree(random_boxes(count, count), {}, "random");
        expect_oracle_tree(grid_boxes(count, count), {1.2f, 1.0f, 1}, "grid");
    }
    for (const SweepSahConfig& config :
         {SweepSahConfig{}, SweepSahConfig{1.2f, 1.0f, 1}, SweepSahConfig{0.5f, 2.0f, 64}, SweepSahConfig{9, 1, 20}}) {
        for (const std::size_t count : {333u, 3000u}) {
            expect_oracle_tree(random_boxes(count), config, "random");
            expect_oracle_tree(grid_boxes(count), config, "grid");
        }
    }
}

TEST_CASE("sweep SAH searches large ranges in parallel, as exactly", "[host][sweep_sah]") {
    expect_oracle_tree(random_boxes(70'001), {}, "random");
    expect_oracle_tree(grid_boxes(66'000), {}, "grid");
}

TEST_CASE("sweep SAH builds the same bytes on any number of threads", "[host][sweep_sah]") {
    const std::vector<Aabb> boxes = random_boxes(200'000);
    const Bvh sequential = build_on_threads(1, boxes);
    CHECK(validate(sequential, mesh_of_boxes(boxes)).error == "");
    for (const int threads : {2, 3, 8}) {
        const Bvh parallel = build_on_threads(threads, boxes);
        CHECK((parallel.nodes == sequential.nodes));
        CHECK((parallel.primitive_ids == sequential.primitive_ids));
    }
}

TEST_CASE("sweep SAH builds valid trees of bounded depth over the hardest boxes", "[host][sweep_sah]") {
    for (const std::size_t count : {2u, 3u, 50u, 100'000u}) {
        for (const BoxSet& set : hard_box_sets(count)) {
            INFO(set.name << ", " << count);
            const ValidationReport report = validate(build_sweep_sah(set.boxes), mesh_of_boxes(set.boxes));
            CHECK(report.error == "");
            CHECK(report.depth <= 288);
        }
    }
}

TEST_CASE("boxes that cost the same wherever they are parted are halved", "[host][sweep_sah]") {
    // One half area that any number of boxes multiplies exactly, and one that is rounded.
    for (const float size : {1.0f, 0.1f}) {
        const std::vector<Aabb> boxes(100'000, Aabb{{0, 0, 0}, {size, size, size}});
        CHECK(validate(build_sweep_sah(boxes, {1.2f, 1.0f, 1}), mesh_of_boxes(boxes)).depth <= 34);
    }
}

TEST_CASE("sweep SAH finds clusters that are as far apart as coordinates can be", "[host][sweep_sah]") {
    // Half area times count would overflow float32.
    std::vector<Aabb> boxes = random_boxes(100'000);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const float shift = i % 3 == 0 ? -0.9e18f : 0.9e18f;
        for (Vec3* corner : {&boxes[i].lower, &boxes[i].upper}) {
            corner->x = corner->x * 1e15f + shift;
            corner->y = corner->y * 1e15f + shift;
            corner->z *= 0.9e17f;
        }
    }
    const Bvh bvh = build_sweep_sah(boxes);
    REQUIRE(validate(bvh, mesh_of_boxes(boxes)).error == "");
    CHECK(bvh.nodes[2].upper[0] < 0.0f);
    CHECK(bvh.nodes[3].lower[0] > 0.0f);
}

TEST_CASE("sweep SAH names the first field that is out of range", "[host][sweep_sah]") {
    const std::vector<Aabb> boxes = random_boxes(3);
    const auto expect_rejected = [&](const SweepSahConfig& config, const std::string& part) {
        expect_error(ErrorCode::invalid_input, {part}, [&] { (void)build_sweep_sah(boxes, config); });
    };
    expect_rejected({0.0f, 1.0f, 8}, "inner_cost is 0");
    expect_rejected({1.2f, -1.0f, 8}, "primitive_cost is -1");
    expect_rejected({1.2f, 1.0f, 0}, "max_leaf_size is 0");
    expect_rejected({1.2f, 1.0f, 65}, "max_leaf_size is 65");
    CHECK(build_sweep_sah({}).empty());
}
