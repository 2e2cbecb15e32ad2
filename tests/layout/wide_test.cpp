// Layouts of eight and of four children a node: against the binary tree that they are made of.
#include "clbvh/layout/wide.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "clbvh/builder.hpp"
#include "clbvh/io/scene.hpp"
#include "support/allocations.hpp"
#include "support/expect_error.hpp"
#include "support/hard_trees.hpp"

using namespace clbvh;
using namespace clbvh::test;

namespace {

bool contains(const Aabb& outer, const Aabb& inner) {
    return merge(outer, inner) == outer;
}

template <std::uint32_t Width>
Aabb box_of(const WideNode<Width>& node, std::uint32_t slot) {
    const auto corner = [&](std::size_t side) {
        return Vec3{node.bounds[side][0][slot], node.bounds[side][1][slot], node.bounds[side][2][slot]};
    };
    return {corner(0), corner(1)};
}

/// Walks a layout, and says what is wrong with it.
template <std::uint32_t Width>
class LayoutCheck {
public:
    LayoutCheck(const WideLayout<Width>& layout, const Bvh& bvh, const Mesh& mesh) : layout_(layout), mesh_(mesh) {
        for (const Node& node : bvh.nodes)
            ++boxes_[key(node.bounds())];
        for (const std::uint32_t id : bvh.primitive_ids)
            ++expected_[id];
    }

    std::string run() {
        struct Visit {
            std::uint32_t node, level;
            Aabb box;
        };
        const float inf = std::numeric_limits<float>::infinity();
        std::vector<Visit> open{{0, 1, {{-inf, -inf, -inf}, {inf, inf, inf}}}};
        std::uint32_t depth = 0;
        std::size_t nodes = 0;
        while (!open.empty()) {
            const Visit visit = open.back();
            open.pop_back();
            ++nodes;
            depth = std::max(depth, visit.level);
            const WideNode<Width>& node = layout_.nodes[visit.node];
            bool has_ended = false;
            std::uint32_t next = 0;
            for (std::uint32_t slot = 0; slot < Width; ++slot) {
                const Aabb box = box_of(node, slot);
                const std::uint32_t child = node.children[slot];
                if (child == WideChild::kNone) {
                    has_ended = true;
                    if (box != Aabb{}) return "the box of no child is not empty";
                    continue;
                }
                if (has_ended) return "a child stands behind the end";
                if (!contains(visit.box, box)) return "a box is not within its parent's";
                if (boxes_.count(key(box)) == 0) return "a box is none of the binary tree's";
                if (WideChild::is_leaf(child)) {
                    visit_leaf(child, box);
                } else {
                    if (next != 0 && child != next) return "the children of a node are not one behind the other";
                    next = child + 1;
                    open.push_back({child, visit.level + 1, box});
                }
            }
        }
        if (depth != layout_.depth) return "wrong depth";
        if (nodes != layout_.nodes.size()) return "nodes that nothing leads to";
        if (blocks_ != layout_.blocks.size()) return "blocks that nothing leads to";
        if (found_ != expected_) return "other primitives than the binary tree's";
        return fault_;
    }

private:
    static std::vector<float> key(const Aabb& box) {
        return {box.lower.x, box.lower.y, box.lower.z, box.upper.x, box.upper.y, box.upper.z};
    }

    void visit_leaf(std::uint32_t leaf, const Aabb& box) {
        for (std::uint32_t i = 0; i < WideChild::block_count(leaf); ++i) {
            const TriangleBlock& block = layout_.blocks[WideChild::first_block(leaf) + i];
            ++blocks_;
            for (std::uint32_t lane = 0; lane < kBlockTriangles; ++lane) {
                if (block.primitives[lane] == kNoPrimitive) {
                    if (!std::isnan(block.vertices[0][0][lane])) fault_ = "no primitive, but vertices";
                    continue;
                }
                ++found_[block.primitives[lane]];
                check_vertices(block, lane, box);
            }
        }
    }

    void check_vertices(const TriangleBlock& block, std::uint32_t lane, const Aabb& box) {
        const Triangle& triangle = mesh_.triangles[block.primitives[lane]];
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3 vertex{block.vertices[corner][0][lane], block.vertices[corner][1][lane],
                              block.vertices[corner][2][lane]};
            const Vec3& expected = mesh_.vertices[triangle[corner]];
            if (std::memcmp(&vertex, &expected, sizeof vertex) != 0) fault_ = "other vertices than the mesh's";
            if (!splits_ && !contains(box, {vertex, vertex})) fault_ = "a vertex is not in its leaf's box";
        }
    }

public:
    bool splits_ = false;  ///< Boxes may hold parts of triangles.

private:
    const WideLayout<Width>& layout_;
    const Mesh& mesh_;
    std::map<std::vector<float>, int> boxes_;
    std::map<std::uint32_t, int> expected_, found_;
    std::size_t blocks_ = 0;
    std::string fault_;
};

template <typename Layout>
std::string fault_of(const Bvh& bvh, const Mesh& mesh) {
    const Layout layout = make_layout<Layout>(bvh, mesh);
    LayoutCheck check(layout, bvh, mesh);
    check.splits_ = bvh.split_references;
    return check.run();
}

std::vector<std::byte> bytes_of(const Wide8& layout) {
    std::vector<std::byte> bytes(layout.nodes.size() * sizeof(WideNode<8>) +
                                 layout.blocks.size() * sizeof(TriangleBlock));
    std::memcpy(bytes.data(), layout.nodes.data(), layout.nodes.size() * sizeof(WideNode<8>));
    std::memcpy(bytes.data() + layout.nodes.size() * sizeof(WideNode<8>), layout.blocks.data(),
                layout.blocks.size() * sizeof(TriangleBlock));
    return bytes;
}

}  // namespace

TEST_CASE("wide layouts hold all triangles of the binary tree, within its boxes") {
    for (const char* scene : {"hair", "city", "soup"}) {
        for (const std::uint64_t count : {1u, 2u, 4u, 5u, 9u, 33u, 4000u}) {
            const Mesh mesh = generate_scene(scene, count);
            for (const char* id : {"binned-sah", "sbvh", "locally-ordered"}) {
                for (const std::uint32_t max_leaf : {0u, 3u, 8u, 64u}) {
                    BuildOptions options;
                    options.max_leaf_size = max_leaf;
                    const Bvh bvh = build(mesh, id, options);
                    INFO(scene << ' ' << count << ", " << id << ", leaves of " << max_leaf);
                    CHECK(fault_of<Wide8>(bvh, mesh).empty());
                    CHECK(fault_of<Wide4>(bvh, mesh).empty());
                }
            }
        }
    }
}

TEST_CASE("trees of unusual shapes are laid out") {
    const Mesh mesh = generate_scene("soup", 3000), line = line_of_points(500);
    for (const Bvh& bvh : {chain_tree(mesh), with_strays(chain_tree(mesh)), with_strays(build(mesh, "median"))}) {
        CHECK(fault_of<Wide8>(bvh, mesh).empty());
        CHECK(fault_of<Wide4>(bvh, mesh).empty());
    }
    CHECK(fault_of<Wide8>(build(line, "median"), line).empty());
}

TEST_CASE("a leaf of any size is laid out") {
    for (const std::uint32_t count : {1u, 4u, 5u, 32u, 33u, 64u, 256u, 257u, 3000u}) {
        const Mesh mesh = generate_scene("soup", count);
        Bvh bvh;
        bvh.primitive_count = count;
        Aabb box;
        for (std::uint32_t i = 0; i < count; ++i) {
            bvh.primitive_ids.push_back(count - 1 - i);
            box = merge(box, triangle_bounds(mesh, i));
        }
        bvh.nodes = {{{box.lower.x, box.lower.y, box.lower.z}, 0, {box.upper.x, box.upper.y, box.upper.z}, count}};
        INFO(count);
        CHECK(fault_of<Wide8>(bvh, mesh).empty());
        CHECK(fault_of<Wide4>(bvh, mesh).empty());
    }
}

TEST_CASE("the same bytes come from any number of threads, and in memory that was used before") {
    const Mesh mesh = generate_scene("city", 30000), small = generate_scene("hair", 100);
    const Bvh bvh = build(mesh, "binned-sah"), small_bvh = build(small, "binned-sah");
    const std::vector<std::byte> expected = bytes_of(make_layout<Wide8>(bvh, mesh, {.thread_count = 1}));
    Wide8 layout;
    for (const std::uint32_t threads : {0u, 2u, 7u}) {
        make_layout(bvh, mesh, layout, {.thread_count = threads});
        CHECK(bytes_of(layout) == expected);
        const void* const memory = layout.nodes.data();
        make_layout(small_bvh, small, layout, {.thread_count = threads});
        CHECK(bytes_of(layout) == bytes_of(make_layout<Wide8>(small_bvh, small)));
        CHECK(layout.nodes.data() == memory);
    }
    make_layout(Bvh{}, Mesh{}, layout);
    CHECK(layout.empty());
    CHECK(layout.depth == 0);
}

TEST_CASE("a layout for which there is no memory is left empty") {
    const Mesh mesh = generate_scene("city", 3000);
    const Bvh bvh = build(mesh, "median");
    Wide8 layout = make_layout<Wide8>(bvh, mesh, {.thread_count = 1});
    long allowed = 0;
    for (bool is_made = false; !is_made; ++allowed) {
        allow_allocations(allowed);
        try {
            make_layout(bvh, mesh, layout, {.thread_count = 1});
            is_made = true;
        } catch (const Error& error) {
            allow_allocations(-1);
            REQUIRE(error.code() == ErrorCode::out_of_memory);
            REQUIRE((layout.empty() && layout.blocks.empty() && layout.depth == 0 && layout.primitive_count == 0));
        }
    }
    allow_allocations(-1);
    CHECK(allowed > 5);
    CHECK(fault_of<Wide8>(bvh, mesh).empty());
}

TEST_CASE("a tree that is none over the mesh has no layout") {
    const Mesh mesh = generate_scene("soup", 50);
    Bvh bvh = build(mesh, "median");
    bvh.primitive_ids[7] = 50;
    expect_error(ErrorCode::invalid_input, {"primitive 50 is out of range"},
                 [&] { static_cast<void>(make_layout<Wide8>(bvh, mesh)); });
    expect_error(ErrorCode::invalid_input, {"thread_count"},
                 [&] { static_cast<void>(make_layout<Wide8>(bvh, mesh, {.thread_count = 1025})); });
}
