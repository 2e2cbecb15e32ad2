#include "host/agglomerative/cluster_tree.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

namespace clbvh::host {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Nodes of one task.
constexpr std::uint32_t kChunk = 512;
/// Enough for 4^kMaxLevels slots.
constexpr std::size_t kMaxLevels = 15;

constexpr std::uint32_t groups_for(std::size_t count) noexcept {
    return static_cast<std::uint32_t>((count + 3) / 4);
}

float least_of(const float (&values)[4]) noexcept {
    return std::min(std::min(values[0], values[1]), std::min(values[2], values[3]));
}
float most_of(const float (&values)[4]) noexcept {
    return std::max(std::max(values[0], values[1]), std::max(values[2], values[3]));
}

/// half_area() of four boxes with these extents, with the same order of operations.
Float4 half_areas(Float4 x, Float4 y, Float4 z) noexcept {
    return x * (y + z) + y * z;
}

template <typename Work>
void for_each(std::uint32_t count, const Work& work) {
    tbb::parallel_for(0u, (count + kChunk - 1) / kChunk, [&](std::uint32_t chunk) {
        for (std::uint32_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i)
            work(i);
    });
}

}  // namespace

ClusterTree::ClusterTree(Scratch& scratch, std::size_t capacity)
    : all_leaves_(scratch.take<Leaf>(groups_for(capacity))) {
    std::size_t groups = 0;
    for (std::uint32_t nodes = groups_for(capacity); nodes > 1; nodes = groups_for(nodes))
        groups += groups_for(nodes);
    all_groups_ = scratch.take<Group>(groups);
}

void ClusterTree::assign(std::span<const Reference> boxes) {
    leaves_ = all_leaves_.first(groups_for(boxes.size()));
    levels_.clear();
    std::size_t used = 0;
    for (std::size_t nodes = leaves_.size(); nodes > 1; nodes = groups_for(nodes)) {
        levels_.push_back(all_groups_.subspan(used, groups_for(nodes)));
        used += levels_.back().size();
        // The last group may have less than four nodes.
        Group& last = levels_.back().back();
        for (std::uint32_t lane = 0; lane < 4; ++lane) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                last.most_lower[axis][lane] = -kInfinity;
                last.least_upper[axis][lane] = kInfinity;
                last.least_extent[axis][lane] = kInfinity;
            }
            last.least_area[lane] = kInfinity;
        }
    }
    for (auto slot = static_cast<std::uint32_t>(boxes.size()); slot < 4 * leaves_.size(); ++slot)
        clear(slot);
    for_each(static_cast<std::uint32_t>(boxes.size()), [&](std::uint32_t slot) { set(slot, boxes[slot]); });
    refit();
}

void ClusterTree::set(std::uint32_t slot, const Reference& box) noexcept {
    Leaf& leaf = leaves_[slot / 4];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        leaf.lower[axis][slot % 4] = box.lower[axis];
        leaf.upper[axis][slot % 4] = box.upper[axis];
    }
}

/// An empty slot is infinitely far from everything, and changes no bound.
void ClusterTree::clear(std::uint32_t slot) noexcept {
    Leaf& leaf = leaves_[slot / 4];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        leaf.lower[axis][slot % 4] = -kInfinity;
        leaf.upper[axis][slot % 4] = kInfinity;
    }
}

void ClusterTree::refit() {
    if (levels_.empty()) return;
    for_each(static_cast<std::uint32_t>(leaves_.size()), [&](std::uint32_t leaf) { refit_leaf(leaf); });
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        for_each(static_cast<std::uint32_t>(levels_[level - 1].size()),
                 [&](std::uint32_t group) { refit_group(level, group); });
    }
}

void ClusterTree::refit_above(std::uint32_t slot) noexcept {
    if (levels_.empty()) return;
    refit_leaf(slot / 4);
    for (std::size_t level = 1; level < levels_.size(); ++level)
        refit_group(level, slot >> (2 * level + 2));
}

/// Writes the bounds of a leaf, a node of level 1.
void ClusterTree::refit_leaf(std::uint32_t leaf) noexcept {
    const Leaf& source = leaves_[leaf];
    Group& target = levels_[0][leaf / 4];
    const std::uint32_t lane = leaf % 4;
    std::array<Float4, 3> extents;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        extents[axis] = Float4::load(source.upper[axis]) - Float4::load(source.lower[axis]);
        float extent[4];
        extents[axis].store(extent);
        target.most_lower[axis][lane] = most_of(source.lower[axis]);
        target.least_upper[axis][lane] = least_of(source.upper[axis]);
        target.least_extent[axis][lane] = least_of(extent);
    }
    float areas[4];
    half_areas(extents[0], extents[1], extents[2]).store(areas);
    target.least_area[lane] = least_of(areas);
}

/// Writes the bounds of what lies below a group, at one lane of the next level.
void ClusterTree::refit_group(std::size_t level, std::uint32_t group) noexcept {
    const Group& source = levels_[level - 1][group];
    Group& target = levels_[level][group / 4];
    const std::uint32_t lane = group % 4;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        target.most_lower[axis][lane] = most_of(source.most_lower[axis]);
        target.least_upper[axis][lane] = least_of(source.least_upper[axis]);
        target.least_extent[axis][lane] = least_of(source.least_extent[axis]);
    }
    target.least_area[lane] = least_of(source.least_area);
}

/// Branch and bound, from the slot's own leaf upwards: what is nearest is mostly close in the tree as well. All bounds
/// are computed with the operations of the distance itself, each of which is monotone in float32: so they are exact.
class ClusterTree::Search {
public:
    Search(const ClusterTree& tree, std::uint32_t slot, const Reference& box) noexcept : tree_(tree), slot_(slot) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower_[axis] = Float4::filled(box.lower[axis]);
            upper_[axis] = Float4::filled(box.upper[axis]);
        }
    }

    Neighbour run() noexcept {
        search_leaf(slot_ / 4);
        for (std::size_t level = 1; level <= tree_.levels_.size(); ++level) {
            const std::uint32_t own = slot_ >> (2 * level);
            push_group(level, own / 4, own);
            search_stack();
        }
        return best_;
    }

private:
    /// A node whose boxes may be nearer than the best.
    struct Candidate {
        float bound;
        std::uint32_t level;
        std::uint32_t node;
    };

    void search_stack() noexcept {
        while (size_ > 0) {
            const Candidate candidate = stack_[--size_];
            if (!may_improve(candidate)) continue;
            if (candidate.level == 1) {
                search_leaf(candidate.node);
            } else {
                push_group(candidate.level - 1, candidate.node, kNone);
            }
        }
    }

    [[nodiscard]] bool may_improve(const Candidate& candidate) const noexcept {
        if (candidate.bound != best_.distance) return candidate.bound < best_.distance;
        const std::uint32_t least_xor = ((slot_ >> (2 * candidate.level)) ^ candidate.node) << (2 * candidate.level);
        return least_xor < (slot_ ^ best_.slot);
    }

    /// The lanes that are not beyond the best: mostly none, which is found without a branch for each.
    [[nodiscard]] std::uint32_t promising(Float4 distances) const noexcept {
        return less_equal(distances, Float4::filled(best_.distance)).bits();
    }

    void search_leaf(std::uint32_t leaf) noexcept {
        const Leaf& boxes = tree_.leaves_[leaf];
        std::array<Float4, 3> extents;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            extents[axis] =
                max(upper_[axis], Float4::load(boxes.upper[axis])) - min(lower_[axis], Float4::load(boxes.lower[axis]));
        }
        const Float4 distances = half_areas(extents[0], extents[1], extents[2]);
        float distance[4];
        distances.store(distance);
        for (std::uint32_t lanes = promising(distances); lanes != 0; lanes &= lanes - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
            const std::uint32_t other = 4 * leaf + lane;
            if (distance[lane] > best_.distance || other == slot_) continue;
            if (distance[lane] < best_.distance || (slot_ ^ other) < (slot_ ^ best_.slot)) {
                best_ = {distance[lane], other};
            }
        }
    }

    /// Pushes the nodes of a group of `level`, save `skipped`, that may improve, the most promising one last.
    void push_group(std::size_t level, std::uint32_t group, std::uint32_t skipped) noexcept {
        const Group& nodes = tree_.levels_[level - 1][group];
        std::array<Float4, 3> extents;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Float4 reach = max(upper_[axis], Float4::load(nodes.least_upper[axis])) -
                                 min(lower_[axis], Float4::load(nodes.most_lower[axis]));
            extents[axis] = max(reach, Float4::load(nodes.least_extent[axis]));
        }
        const Float4 bounds = max(half_areas(extents[0], extents[1], extents[2]), Float4::load(nodes.least_area));
        float bound[4];
        bounds.store(bound);
        const std::size_t first = size_;
        for (std::uint32_t lanes = promising(bounds); lanes != 0; lanes &= lanes - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
            const Candidate candidate{bound[lane], static_cast<std::uint32_t>(level), 4 * group + lane};
            if (candidate.node == skipped || !may_improve(candidate)) continue;
            std::size_t place = size_++;
            for (; place > first && stack_[place - 1].bound < candidate.bound; --place)
                stack_[place] = stack_[place - 1];
            stack_[place] = candidate;
        }
    }

    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    const ClusterTree& tree_;
    std::uint32_t slot_;
    std::array<Float4, 3> lower_;
    std::array<Float4, 3> upper_;
    Neighbour best_;
    std::size_t size_ = 0;
    std::array<Candidate, 4 * kMaxLevels> stack_;
};

ClusterTree::Neighbour ClusterTree::find_nearest(std::uint32_t slot, const Reference& box) const noexcept {
    return Search(*this, slot, box).run();
}

}  // namespace clbvh::host
