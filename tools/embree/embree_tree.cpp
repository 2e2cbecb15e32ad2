#include "embree/embree_tree.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <vector>

namespace clbvh::tool {
namespace {

constexpr std::uintptr_t kLeafBit = 1;
constexpr std::uintptr_t kSinglePrimitiveBit = 2;
constexpr unsigned kSinglePrimitiveShift = 2;

/// Followed by `count` ids.
struct EmbreeLeaf {
    std::uint32_t count;

    std::uint32_t* ids() { return reinterpret_cast<std::uint32_t*>(this + 1); }
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
    return rtcThreadLocalAlloc(allocator, sizeof(EmbreeNode), sizeof(EmbreeNode));
}

void set_node_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) {
        const RTCBounds& b = *bounds[i];
        static_cast<EmbreeNode*>(node)->bounds[i] = {{b.lower_x, b.lower_y, b.lower_z},
                                                     {b.upper_x, b.upper_y, b.upper_z}};
    }
}

void set_node_children(void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i)
        static_cast<EmbreeNode*>(node)->children[i] = children[i];
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count, void*) {
    if (count == 1) {
        const std::uintptr_t id = primitives->primID;
        // No address, only its bits. NOLINTNEXTLINE(performance-no-int-to-ptr)
        return reinterpret_cast<EmbreeChild>(id << kSinglePrimitiveShift | kSinglePrimitiveBit | kLeafBit);
    }
    void* memory = rtcThreadLocalAlloc(allocator, sizeof(EmbreeLeaf) + count * sizeof(std::uint32_t), 8);
    auto* leaf = new (memory) EmbreeLeaf{static_cast<std::uint32_t>(count)};
    for (std::size_t i = 0; i < count; ++i)
        leaf->ids()[i] = primitives[i].primID;
    return reinterpret_cast<std::byte*>(leaf) + kLeafBit;
}

/// Reads a tree depth-first.
class Reader {
public:
    Bvh read(EmbreeChild root, const Aabb& root_bounds) {
        bvh_.nodes.resize(2);
        set(0, root, root_bounds);
        while (!pending_.empty()) {
            const Pending next = pending_.back();
            pending_.pop_back();
            const auto first = static_cast<std::uint32_t>(bvh_.nodes.size());
            bvh_.nodes[next.slot].first = first;
            bvh_.nodes.resize(bvh_.nodes.size() + 2);
            // The left child is entered next.
            for (const std::uint32_t i : {1u, 0u})
                set(first + i, next.node->children[i], next.node->bounds[i]);
        }
        return std::move(bvh_);
    }

private:
    struct Pending {
        std::uint32_t slot;
        const EmbreeNode* node;
    };

    void set(std::uint32_t slot, EmbreeChild child, const Aabb& b) {
        bvh_.nodes[slot] = {{b.lower.x, b.lower.y, b.lower.z}, 0, {b.upper.x, b.upper.y, b.upper.z}, 0};
        const auto bits = reinterpret_cast<std::uintptr_t>(child);
        if ((bits & kLeafBit) == 0) {
            pending_.push_back({slot, static_cast<const EmbreeNode*>(child)});
        } else if ((bits & kSinglePrimitiveBit) != 0) {
            const auto id = static_cast<std::uint32_t>(bits >> kSinglePrimitiveShift);
            append_leaf(bvh_.nodes[slot], {&id, 1});
        } else {
            auto* leaf = reinterpret_cast<EmbreeLeaf*>(static_cast<std::byte*>(child) - kLeafBit);
            append_leaf(bvh_.nodes[slot], {leaf->ids(), leaf->count});
        }
    }

    void append_leaf(Node& node, std::span<const std::uint32_t> ids) {
        std::vector<std::uint32_t>& all = bvh_.primitive_ids;
        node.first = static_cast<std::uint32_t>(all.size());
        all.insert(all.end(), ids.begin(), ids.end());
        const auto begin = all.begin() + node.first;
        std::sort(begin, all.end());
        all.erase(std::unique(begin, all.end()), all.end());
        node.count = static_cast<std::uint32_t>(all.size()) - node.first;
    }

    Bvh bvh_;
    std::vector<Pending> pending_;
};

}  // namespace

void set_tree_callbacks(RTCBuildArguments& arguments) {
    arguments.createNode = create_node;
    arguments.setNodeBounds = set_node_bounds;
    arguments.setNodeChildren = set_node_children;
    arguments.createLeaf = create_leaf;
}

Bvh read_tree(EmbreeChild root, const Aabb& root_bounds) {
    return Reader().read(root, root_bounds);
}

}  // namespace clbvh::tool
