// Rotations save what they say; hill climbing ends where none saves anything; annealing goes further.
#include "clbvh/optimize/rotate.hpp"

#include <catch2/catch.hpp>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "clbvh/metrics/sah.hpp"
#include "optimize/tree_rotation.hpp"
#include "support/builders.hpp"
#include "support/expect_error.hpp"

using namespace clbvh;
using namespace clbvh::test;
using optimizer::EditTree;
using optimizer::TreeRotation;

namespace {

std::vector<std::uint32_t> inner_slots(const Bvh& tree) {
    std::vector<std::uint32_t> slots, stack{0};
    while (!stack.empty()) {
        const std::uint32_t slot = stack.back();
        stack.pop_back();
        if (tree.nodes[slot].is_leaf()) continue;
        slots.push_back(slot);
        stack.insert(stack.end(), {tree.nodes[slot].first, tree.nodes[slot].first + 1});
    }
    return slots;
}

/// Goes through the candidates and keeps the `wanted`-th.
struct PickOne {
    std::uint32_t wanted;
    bool operator()(const TreeRotation&, const TreeRotation&, std::uint32_t index) const { return index == wanted; }
};

}  // namespace

TEST_CASE("rotate: each of the six exchanges saves what the areas say afterwards") {
    const Mesh mesh = generate_scene("city", 200);
    const Bvh tree = built_tree("lbvh", mesh);
    std::size_t seen = 0;
    for (const std::uint32_t slot : inner_slots(tree)) {
        for (std::uint32_t index = 0; index < 6; ++index) {
            Bvh rotated = tree;
            EditTree edit(rotated.nodes);
            const double before = edit.inner_half_area();
            const TreeRotation rotation = best_rotation(edit, slot, PickOne{index});
            if (!rotation) continue;
            ++seen;
            make_rotation(edit, slot, rotation);
            INFO("slot " << slot << ", exchange " << index);
            CHECK(before - edit.inner_half_area() == Approx(rotation.saved).margin(1e-9 * before));
            REQUIRE(validate(rotated, mesh).error == "");
        }
    }
    CHECK(seen > 400);
}

TEST_CASE("rotate: where it ends, no exchange saves anything") {
    for (const char* const builder : {"lbvh", "sweep-sah", "plocpp"}) {
        Bvh tree = rotate(built_tree(builder, generate_scene("clustered", 3000)));
        const EditTree edit(tree.nodes);
        for (const std::uint32_t slot : inner_slots(tree)) {
            INFO(builder << ", slot " << slot);
            CHECK_FALSE(best_rotation(edit, slot, optimizer::GreedyChoice{}));
        }
    }
}

TEST_CASE("rotate: siblings are ordered along the axis that separates them best") {
    const Bvh tree = rotate(built_tree("lbvh", generate_scene("city", 2000)));
    for (const std::uint32_t slot : inner_slots(tree)) {
        const Node& a = tree.nodes[tree.nodes[slot].first];
        const Node& b = tree.nodes[tree.nodes[slot].first + 1];
        float forwards = -std::numeric_limits<float>::infinity(), backwards = forwards;
        for (int axis = 0; axis < 3; ++axis) {
            forwards = std::max(forwards, b.lower[axis] - a.upper[axis]);
            backwards = std::max(backwards, a.lower[axis] - b.upper[axis]);
        }
        CHECK(forwards >= backwards);
    }
}

TEST_CASE("anneal: goes below hill climbing, depends on its seed alone, and cold is hill climbing") {
    const Bvh tree = built_tree("lbvh", generate_scene("clustered", 3000));
    const double climbed = sah_cost(rotate(tree));
    AnnealConfig config;
    config.length = 300;
    const Bvh annealed = anneal(tree, config);
    CHECK(sah_cost(annealed) < 0.99 * climbed);
    CHECK(same_bytes(annealed, anneal(tree, config)));
    config.seed = 2;
    CHECK_FALSE(same_bytes(annealed, anneal(tree, config)));
    config.hottest = 0.0f;
    CHECK(sah_cost(anneal(tree, config)) == Approx(climbed).epsilon(1e-12));
}

TEST_CASE("rotate, anneal: fields out of range are named") {
    const Bvh tree = make_builder("median").build(generate_scene("soup", 10));
    const auto refuses = [&](const std::string& field, auto&& change) {
        AnnealConfig config;
        change(config);
        expect_error(ErrorCode::invalid_input, {field}, [&] { static_cast<void>(anneal(tree, config)); });
    };
    refuses("length", [](AnnealConfig& c) { c.length = 0; });
    refuses("period", [](AnnealConfig& c) { c.period = 0.0f; });
    refuses("hottest", [](AnnealConfig& c) { c.hottest = -1.0f; });
    RotateConfig config;
    config.least_gain = std::numeric_limits<float>::quiet_NaN();
    expect_error(ErrorCode::invalid_input, {"least_gain"}, [&] { static_cast<void>(rotate(tree, config)); });
}
