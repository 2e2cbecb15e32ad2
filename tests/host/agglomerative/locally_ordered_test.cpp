#include "clbvh/host/locally_ordered.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <catch2/catch.hpp>
#include <vector>

#include "clbvh/core/validate.hpp"
#include "support/box_sets.hpp"
#include "support/oracle/greedy_oracle.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

void expect_greedy_tree(const std::vector<Aabb>& boxes) {
    const Bvh bvh = build_locally_ordered(boxes);
    REQUIRE(validate(bvh, mesh_of_boxes(boxes)).error == "");
    REQUIRE(validate(bvh, mesh_of_boxes(boxes)).leaves == boxes.size());
    CHECK(check_greedy(bvh, boxes) == "");
}

Bvh build_on_threads(int threads, const std::vector<Aabb>& boxes) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] { return build_locally_ordered(boxes); });
}

}  // namespace

TEST_CASE("locally-ordered clustering gives the greedy tree", "[host][locally_ordered]") {
    for (std::uint32_t count = 1; count <= 70; ++count) {
        INFO(count << " boxes");
        expect_greedy_tree(random_boxes(count, count));
        expect_greedy_tree(grid_boxes(count, count));
    }
    for (const std::size_t count : {257u, 1000u, 3000u}) {
        INFO(count << " boxes");
        expect_greedy_tree(random_boxes(count));
        expect_greedy_tree(grid_boxes(count));
    }
}

TEST_CASE("locally-ordered clustering gives a greedy tree of the hardest boxes", "[host][locally_ordered]") {
    for (const std::size_t count : {2u, 5u, 16u, 400u}) {
        for (const BoxSet& set : hard_box_sets(count)) {
            INFO(set.name << ", " << count);
            expect_greedy_tree(set.boxes);
        }
    }
}

TEST_CASE("a tree that is not greedy is told from one that is", "[host][locally_ordered]") {
    // Two pairs of points; the tree below joins one of each.
    const std::vector<Aabb> boxes{
        {{0, 0, 0}, {0, 1, 1}}, {{1, 0, 0}, {1, 1, 1}}, {{5, 0, 0}, {5, 1, 1}}, {{6, 0, 0}, {6, 1, 1}}};
    const auto leaf = [&](std::uint32_t id) {
        const Aabb& box = boxes[id];
        return Node{{box.lower.x, 0, 0}, id, {box.upper.x, 1, 1}, 1};
    };
    Bvh bvh;
    bvh.nodes = {Node{{0, 0, 0}, 2, {6, 1, 1}, 0},
                 {},
                 Node{{0, 0, 0}, 4, {5, 1, 1}, 0},
                 Node{{1, 0, 0}, 6, {6, 1, 1}, 0},
                 leaf(0),
                 leaf(2),
                 leaf(1),
                 leaf(3)};
    bvh.primitive_ids = {0, 1, 2, 3};
    bvh.primitive_count = 4;
    REQUIRE(validate(bvh, mesh_of_boxes(boxes)).error == "");
    CHECK(check_greedy(bvh, boxes) != "");
    CHECK(check_greedy(build_locally_ordered(boxes), boxes) == "");
}

TEST_CASE("locally-ordered clustering builds valid trees over many of the hardest boxes", "[host][locally_ordered]") {
    for (const BoxSet& set : hard_box_sets(40'000)) {
        INFO(set.name);
        CHECK(validate(build_locally_ordered(set.boxes), mesh_of_boxes(set.boxes)).error == "");
    }
}

TEST_CASE("equal boxes give a balanced tree", "[host][locally_ordered]") {
    const std::vector<Aabb> boxes(100'000, Aabb{{0, 0, 0}, {0.1f, 0.2f, 0.3f}});
    CHECK(validate(build_locally_ordered(boxes), mesh_of_boxes(boxes)).depth <= 20);
}

TEST_CASE("locally-ordered clustering builds the same bytes on any number of threads", "[host][locally_ordered]") {
    for (const std::vector<Aabb>& boxes : {random_boxes(60'000), grid_boxes(60'000)}) {
        const Bvh sequential = build_on_threads(1, boxes);
        for (const int threads : {2, 3, 8}) {
            const Bvh parallel = build_on_threads(threads, boxes);
            CHECK((parallel.nodes == sequential.nodes));
            CHECK((parallel.primitive_ids == sequential.primitive_ids));
        }
    }
}

TEST_CASE("locally-ordered clustering of no boxes is empty", "[host][locally_ordered]") {
    CHECK(build_locally_ordered({}).empty());
}
