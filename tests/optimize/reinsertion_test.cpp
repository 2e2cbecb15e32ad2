// A reinsertion's place is the best of all places, and its gain what the tree's areas then say, or nothing happens.
#include "optimize/reinsertion.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "clbvh/core/validate.hpp"
#include "clbvh/io/scene.hpp"
#include "optimize/candidates.hpp"
#include "support/builders.hpp"
#include "support/meshes.hpp"

using namespace clbvh;
using namespace clbvh::test;
using optimizer::EditTree;
using optimizer::Reinsertion;
using optimizer::ReinsertionMove;
using optimizer::ReinsertionSearch;

namespace {

/// A tree of pointers, on which a move is made in the plainest way.
struct PlainTree {
    struct Item {
        int parent = -1, left = -1, right = -1;
        Aabb box;
    };
    std::vector<Item> items;
    int root = 0;

    explicit PlainTree(const Bvh& tree) : items(tree.nodes.size()) {
        std::vector<std::uint32_t> stack{0};
        while (!stack.empty()) {
            const std::uint32_t slot = stack.back();
            stack.pop_back();
            const Node& node = tree.nodes[slot];
            items[slot].box = node.bounds();
            if (node.is_leaf()) continue;
            items[slot].left = static_cast<int>(node.first);
            items[slot].right = static_cast<int>(node.first + 1);
            for (const std::uint32_t child : {node.first, node.first + 1}) {
                items[child].parent = static_cast<int>(slot);
                stack.push_back(child);
            }
        }
    }

    Item& at(int i) { return items[static_cast<std::size_t>(i)]; }

    void replace_child(int parent, int before, int now) {
        if (parent < 0)
            root = now;
        else if (at(parent).left == before)
            at(parent).left = now;
        else
            at(parent).right = now;
        at(now).parent = parent;
    }

    /// Takes `node` with its parent out, and puts both above `to`.
    void move(int node, int to) {
        const int parent = at(node).parent;
        const int sibling = at(parent).left == node ? at(parent).right : at(parent).left;
        replace_child(at(parent).parent, parent, sibling);
        replace_child(at(to).parent, to, parent);
        at(parent).left = node;
        at(parent).right = to;
        at(to).parent = parent;
    }

    double fit(int i) {
        if (at(i).left < 0) return 0.0;
        const double below = fit(at(i).left) + fit(at(i).right);
        at(i).box = merge(at(at(i).left).box, at(at(i).right).box);
        return below + area(at(i).box);
    }

    static double area(const Aabb& box) {
        const double x = double{box.upper.x} - double{box.lower.x};
        const double y = double{box.upper.y} - double{box.lower.y};
        const double z = double{box.upper.z} - double{box.lower.z};
        return x * y + y * z + z * x;
    }
    double inner_area() { return fit(root); }

    bool is_below(int node, int ancestor) {
        for (; node >= 0; node = at(node).parent) {
            if (node == ancestor) return true;
        }
        return false;
    }
};

std::vector<std::uint32_t> movable_slots(const Bvh& tree) {
    std::vector<std::uint32_t> slots;
    std::vector<std::uint32_t> stack{tree.nodes[0].first, tree.nodes[0].first + 1};
    while (!stack.empty()) {
        const Node node = tree.nodes[stack.back()];
        stack.pop_back();
        if (node.is_leaf()) continue;
        for (const std::uint32_t child : {node.first, node.first + 1}) {
            slots.push_back(child);
            stack.push_back(child);
        }
    }
    return slots;
}

double best_gain_of_all(const Bvh& tree, std::uint32_t from) {
    const double before = PlainTree(tree).inner_area();
    double best = 0.0;
    PlainTree original(tree);
    const int parent = original.at(static_cast<int>(from)).parent;
    for (std::uint32_t to = 0; to < tree.nodes.size(); ++to) {
        const int target = static_cast<int>(to);
        const bool is_used = to == 0 || original.at(target).parent >= 0;
        if (!is_used || original.is_below(target, static_cast<int>(from)) || target == parent) continue;
        PlainTree moved = original;
        moved.move(static_cast<int>(from), target);
        best = std::max(best, before - moved.inner_area());
    }
    return best;
}

}  // namespace

TEST_CASE("reinsertion: the place that is found is the best of all") {
    for (const char* const scene : {"soup", "clustered", "city", "hair"}) {
        const Bvh tree = built_tree("lbvh", generate_scene(scene, 120));
        Bvh edited = tree;
        const EditTree edit(edited.nodes);
        ReinsertionSearch search(edit);
        const double total = PlainTree(tree).inner_area();
        std::size_t gains = 0;
        for (const std::uint32_t from : movable_slots(tree)) {
            INFO(scene << ", node " << from);
            const Reinsertion found = search.find(from);
            CHECK(found.from == from);
            CHECK(double{found.gain} == Approx(best_gain_of_all(tree, from)).margin(1e-6 * total));
            gains += found.gain > 0.0f ? 1 : 0;
        }
        CHECK(gains > 5);
    }
}

TEST_CASE("reinsertion: a move saves what it says, or leaves every byte as it was") {
    const Mesh mesh = generate_scene("city", 300);
    Bvh tree = built_tree("lbvh", mesh);
    EditTree edit(tree.nodes);
    ReinsertionMove move(edit);
    const std::vector<std::uint32_t> slots = movable_slots(tree);
    std::mt19937 random(7);
    std::size_t made = 0, refused = 0;
    for (int i = 0; i < 4000; ++i) {
        const std::uint32_t from = slots[random() % slots.size()];
        const std::uint32_t to = i % 50 == 0 ? 0 : slots[random() % slots.size()];
        const Bvh before = tree;
        const double saved = move.make(from, to);
        if (saved > 0.0) {
            ++made;
            CHECK(edit.inner_half_area() == Approx(PlainTree(tree).inner_area()).epsilon(1e-12));
            CHECK(PlainTree(before).inner_area() - PlainTree(tree).inner_area() == Approx(saved).epsilon(1e-9));
            REQUIRE(validate(tree, mesh).error == "");
        } else {
            ++refused;
            REQUIRE(same_bytes(tree, before));
        }
    }
    CHECK(made > 20);
    CHECK(refused > 1000);
}

TEST_CASE("reinsertion: candidates are as many as asked for, those first whose parents are much larger") {
    Bvh tree = built_tree("lbvh", generate_scene("clustered", 20000));
    const EditTree edit(tree.nodes);
    optimizer::Candidates candidates(edit);
    CHECK(candidates.initial_area() == edit.inner_half_area());
    const auto worth = [&](std::uint32_t slot) {
        return edit.box(edit.parent(slot)).half_area() - edit.box(slot).half_area();
    };
    const std::vector<std::uint32_t> movable = movable_slots(tree);
    for (const double part : {1e-9, 0.001, 0.1, 0.5, 1.0}) {
        INFO(part);
        const auto chosen = candidates.choose(part);
        const auto wanted = std::max(1.0, std::floor(part * static_cast<double>(movable.size())));
        CHECK(static_cast<double>(chosen.size()) == wanted);
        CHECK(std::is_sorted(chosen.begin(), chosen.end()));
        CHECK(std::adjacent_find(chosen.begin(), chosen.end()) == chosen.end());
        float least = std::numeric_limits<float>::infinity();
        for (const std::uint32_t slot : chosen)
            least = std::min(least, worth(slot));
        // Ranks tell worths apart by an eighth.
        const auto better =
            std::ranges::count_if(movable, [&](std::uint32_t slot) { return worth(slot) > 1.2f * least; });
        CHECK(static_cast<double>(better) <= wanted);
    }
    Bvh equal = built_tree("lbvh", coincident_triangles(5000));
    const EditTree equal_edit(equal.nodes);
    CHECK(optimizer::Candidates(equal_edit).choose(0.01).size() == movable_slots(equal).size() / 100);
}

TEST_CASE("reinsertion: candidates after moves are those of the tree as it then is") {
    Bvh tree = built_tree("lbvh", generate_scene("clustered", 3000));
    EditTree edit(tree.nodes);
    optimizer::Candidates candidates(edit);
    ReinsertionSearch search(edit);
    ReinsertionMove move(edit);
    std::size_t made = 0;
    for (int pass = 0; pass < 3; ++pass) {
        const auto chosen = candidates.choose(0.2);
        for (const std::uint32_t from : std::vector<std::uint32_t>(chosen.begin(), chosen.end())) {
            if (edit.parent(from) == 0) continue;
            const auto found = search.find(from);
            if (!(found.gain > 0.0f) || !(move.make(found.from, found.to) > 0.0)) continue;
            ++made;
            move.for_each_changed([&](std::uint32_t slot) { candidates.touch(slot); });
        }
        for (const double part : {0.01, 0.3, 1.0}) {
            optimizer::Candidates fresh(edit);
            const auto kept = candidates.choose(part);
            CHECK(std::ranges::equal(kept, fresh.choose(part)));
        }
    }
    CHECK(made > 100);
}
