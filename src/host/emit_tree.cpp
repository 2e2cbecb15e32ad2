#include "host/emit_tree.hpp"

#include <tbb/task_group.h>

#include <algorithm>

namespace clbvh::host {
namespace {

/// Where one subtree goes.
struct Place {
    std::uint32_t node;  ///< Slot of its root in the result.
    std::uint32_t pair;  ///< First pair of what lies below.
    std::uint32_t id;    ///< First primitive id.
};

class Emitter {
public:
    Emitter(const TreeSlots& slots, Bvh& result) : slots_(slots), result_(result) {}

    void run() {
        const Extent whole = extent_of(slots_.nodes[0], slots_.extents);
        result_.nodes.resize(2 * (std::size_t{whole.pairs} + 1));
        result_.primitive_ids.resize(whole.primitives);
        result_.nodes[1] = Node{};
        tasks_.run_and_wait([this] { emit(slots_.nodes[0], {0, 1, 0}); });
    }

private:
    static constexpr std::uint32_t kParallelPairs = 4096;

    /// The smaller subtree goes to a task or a call, the larger one to the next turn of the loop: so the stack stays
    /// low whatever the tree.
    void emit(const Node& root, Place place) {
        const Node* node = &root;
        while (true) {
            const Extent extent = extent_of(*node, slots_.extents);
            if (extent.pairs == 0) return emit_leaf(*node, extent.primitives, place);
            Node& target = result_.nodes[place.node];
            target = *node;
            target.first = 2 * place.pair;
            const Node& left = slots_.nodes[node->first];
            const Node& right = slots_.nodes[std::size_t{node->first} + 1];
            const Extent left_extent = extent_of(left, slots_.extents);
            const Extent right_extent = extent_of(right, slots_.extents);
            const Place left_place{2 * place.pair, place.pair + 1, place.id};
            const Place right_place{2 * place.pair + 1, place.pair + 1 + left_extent.pairs,
                                    place.id + left_extent.primitives};
            if (left_extent.pairs < right_extent.pairs) {
                start(left, left_extent, left_place);
                node = &right;
                place = right_place;
            } else {
                start(right, right_extent, right_place);
                node = &left;
                place = left_place;
            }
        }
    }

    void start(const Node& root, const Extent& extent, const Place& place) {
        if (extent.pairs < kParallelPairs) {
            emit(root, place);
        } else {
            tasks_.run([this, &root, place] { emit(root, place); });
        }
    }

    void emit_leaf(const Node& root, std::uint32_t primitives, const Place& place) {
        Node& target = result_.nodes[place.node];
        target = root;
        target.first = place.id;
        target.count = primitives;
        std::uint32_t* next = result_.primitive_ids.data() + place.id;
        collect_ids(root, next);
    }

    /// The ids below `root`, left to right.
    void collect_ids(const Node& root, std::uint32_t*& next) {
        if (root.is_leaf()) {
            next = std::copy_n(slots_.primitive_ids.data() + root.first, root.count, next);
            return;
        }
        collect_ids(slots_.nodes[root.first], next);
        collect_ids(slots_.nodes[std::size_t{root.first} + 1], next);
    }

    const TreeSlots& slots_;
    Bvh& result_;
    tbb::task_group tasks_;
};

}  // namespace

void emit_tree(const TreeSlots& slots, Bvh& result) {
    Emitter(slots, result).run();
}

}  // namespace clbvh::host
