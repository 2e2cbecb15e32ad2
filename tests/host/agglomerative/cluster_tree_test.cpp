#include "host/agglomerative/cluster_tree.hpp"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <random>
#include <tuple>
#include <vector>

#include "host/agglomerative/kd_order.hpp"
#include "host/build/primitive_bounds.hpp"
#include "support/box_sets.hpp"

using namespace clbvh;
using namespace clbvh::host;
using namespace clbvh::test;

namespace {

std::vector<Reference> references_over(const std::vector<Aabb>& boxes) {
    std::vector<Reference> references(boxes.size());
    Scratch scratch;
    bound_primitives(boxes, references, scratch);
    return references;
}

/// Slots and a tree over them, which are changed together.
class Slots {
public:
    explicit Slots(const std::vector<Aabb>& boxes)
        : references_(references_over(boxes)), is_taken_(boxes.size(), true), tree_(scratch_, boxes.size()) {
        order_by_kd_tree(references_);
        tree_.assign(references_);
    }

    [[nodiscard]] ClusterTree& tree() { return tree_; }
    [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(references_.size()); }

    void clear(std::uint32_t slot) {
        is_taken_[slot] = false;
        tree_.clear(slot);
    }
    /// Lets the box in `slot` grow over that of `other`.
    void merge_into(std::uint32_t slot, std::uint32_t other) {
        is_taken_[slot] = true;
        Reference& target = references_[slot];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            target.lower[axis] = std::min(target.lower[axis], references_[other].lower[axis]);
            target.upper[axis] = std::max(target.upper[axis], references_[other].upper[axis]);
        }
        tree_.set(slot, target);
    }

    /// Checks the nearest of each taken slot.
    void expect_nearest() const {
        if (std::ranges::count(is_taken_, true) < 2) return;
        std::uint32_t wrong = 0;
        for (std::uint32_t slot = 0; slot < count(); ++slot) {
            if (!is_taken_[slot]) continue;
            const ClusterTree::Neighbour found = tree_.find_nearest(slot, references_[slot]);
            wrong += std::tuple(found.distance, found.slot) == nearest(slot) ? 0 : 1;
        }
        CHECK(wrong == 0);
    }

private:
    [[nodiscard]] std::tuple<float, std::uint32_t> nearest(std::uint32_t slot) const {
        std::tuple<float, std::uint32_t> best{std::numeric_limits<float>::infinity(), 0};
        for (std::uint32_t j = 0; j < count(); ++j) {
            if (j == slot || !is_taken_[j]) continue;
            best = std::min(best, {half_area(merge(references_[slot].bounds(), references_[j].bounds())), slot ^ j});
        }
        return {std::get<0>(best), std::get<1>(best) ^ slot};
    }

    std::vector<Reference> references_;
    std::vector<bool> is_taken_;
    Scratch scratch_;
    ClusterTree tree_;
};

float coordinate(const Reference& box, std::size_t choice) {
    const std::size_t axis = choice % 3;
    return choice < 3 ? box.lower[axis] + box.upper[axis] : box.upper[axis] - box.lower[axis];
}

/// True where every box of `left` is below every one of `right` along one coordinate.
bool are_parted(std::span<const Reference> left, std::span<const Reference> right) {
    for (std::size_t choice = 0; choice < 6; ++choice) {
        const auto value = [choice](const Reference& box) { return coordinate(box, choice); };
        if (value(*std::ranges::max_element(left, {}, value)) <= value(*std::ranges::min_element(right, {}, value))) {
            return true;
        }
    }
    return false;
}

bool is_kd_order(std::span<const Reference> boxes) {
    if (boxes.size() <= 4) return true;
    const std::size_t middle = std::bit_ceil(boxes.size()) / 2;
    return are_parted(boxes.first(middle), boxes.subspan(middle)) && is_kd_order(boxes.first(middle)) &&
           is_kd_order(boxes.subspan(middle));
}

}  // namespace

TEST_CASE("the cluster tree finds the nearest box, however slots change", "[host][cluster_tree]") {
    for (const std::size_t count : {2u, 3u, 4u, 5u, 16u, 17u, 63u, 64u, 65u, 300u, 1500u}) {
        for (const BoxSet& set : hard_box_sets(count)) {
            INFO(set.name << ", " << count);
            Slots slots(set.boxes);
            slots.expect_nearest();

            std::mt19937 random(3);
            const auto any_slot = [&] { return static_cast<std::uint32_t>(random() % count); };
            for (std::size_t i = 0; i < count / 2; ++i)
                slots.clear(any_slot());
            for (std::size_t i = 0; i < count / 8; ++i)
                slots.merge_into(any_slot(), any_slot());
            slots.tree().refit();
            slots.expect_nearest();

            for (std::size_t i = 0; i < 8; ++i) {
                const std::uint32_t slot = any_slot();
                slots.merge_into(slot, any_slot());
                slots.tree().refit_above(slot);
                const std::uint32_t emptied = any_slot();
                slots.clear(emptied);
                slots.tree().refit_above(emptied);
            }
            slots.expect_nearest();
        }
    }
}

TEST_CASE("the kd order parts every block by one coordinate", "[host][cluster_tree]") {
    for (const std::size_t count : {1u, 4u, 5u, 100u, 1024u, 1025u, 20'000u}) {
        for (const BoxSet& set : hard_box_sets(count)) {
            INFO(set.name << ", " << count);
            std::vector<Reference> boxes = references_over(set.boxes);
            order_by_kd_tree(boxes);
            CHECK(is_kd_order(boxes));
            std::ranges::sort(boxes, {}, &Reference::primitive);
            const std::vector<Reference> expected = references_over(set.boxes);
            CHECK(std::ranges::equal(boxes, expected, [](const Reference& a, const Reference& b) {
                return a.primitive == b.primitive && a.bounds() == b.bounds();
            }));
        }
    }
}
