#include "clbvh/layout/wide.hpp"

#include <tbb/parallel_for.h>

#include <string>

#include "clbvh/core/error.hpp"
#include "core/primitive_access.hpp"
#include "core/simd/float4.hpp"
#include "layout/block_writer.hpp"
#include "layout/check_tree.hpp"
#include "layout/make_in_arena.hpp"
#include "layout/opening.hpp"
#include "layout/wide_converter.hpp"

namespace clbvh::layout {
namespace {

/// Stands for a child that is not there.
constexpr Node kNoNode{{kPositiveInfinity, kPositiveInfinity, kPositiveInfinity},
                       0,
                       {kNegativeInfinity, kNegativeInfinity, kNegativeInfinity},
                       0};
constexpr std::size_t kNodesAhead = 6;

template <std::uint32_t Width>
void write_boxes(const Node* nodes, const OpenedNode<Width>& opened, WideNode<Width>& node) {
    for (std::uint32_t begin = 0; begin < Width; begin += 4) {
        std::array<const Node*, 4> sources;
        for (std::uint32_t lane = 0; lane < 4; ++lane) {
            const std::uint32_t source = opened.nodes[begin + lane];
            sources[lane] = source == kNone ? &kNoNode : nodes + source;
        }
        const auto write_side = [&](auto corner_of, std::size_t side) {
            Float4 a = Float4::load(corner_of(*sources[0])), b = Float4::load(corner_of(*sources[1]));
            Float4 c = Float4::load(corner_of(*sources[2])), d = Float4::load(corner_of(*sources[3]));
            Float4::transpose(a, b, c, d);
            a.store(node.bounds[side][0].data() + begin);
            b.store(node.bounds[side][1].data() + begin);
            c.store(node.bounds[side][2].data() + begin);
        };
        write_side([](const Node& source) { return source.lower; }, 0);
        write_side([](const Node& source) { return source.upper; }, 1);
    }
}

template <std::uint32_t Width>
void write_node(const Node* nodes, const OpenedNode<Width>& opened, const Piece<Width>& piece, WideNode<Width>& node) {
    write_boxes(nodes, opened, node);
    for (std::uint32_t slot = 0; slot < Width; ++slot) {
        const std::uint32_t child = opened.children[slot];
        const std::uint32_t base = WideChild::is_leaf(child) ? piece.first_block : piece.first_node;
        node.children[slot] = child == kNone ? WideChild::kNone : child + base;
    }
}

template <std::uint32_t Width>
void write_nodes(const Node* nodes, const Piece<Width>& piece, bool is_top, WideNode<Width>* target) {
    if (!is_top) write_node(nodes, piece.root_node, piece, target[piece.root]);
    for (std::size_t i = 0; i < piece.nodes.size(); ++i) {
        if (i + kNodesAhead < piece.nodes.size()) {
            for (const std::uint32_t ahead : piece.nodes[i + kNodesAhead].nodes) {
                if (ahead != kNone) prefetch(nodes + ahead);
            }
        }
        write_node(nodes, piece.nodes[i], piece, target[piece.first_node + i]);
    }
}

}  // namespace

template <std::uint32_t Width>
void WideConverter<Width>::run(const TreeView& tree, const MeshView& mesh, WideLayout<Width>& result,
                               NodeOpening opening) {
    make_or_empty(result, [&] { convert(tree, mesh, result, opening); });
}

template <std::uint32_t Width>
void WideConverter<Width>::convert(const TreeView& tree, const MeshView& mesh, WideLayout<Width>& result,
                                   NodeOpening opening) {
    result.primitive_count = tree.primitive_count;
    result.split_references = tree.split_references;
    if (tree.nodes.empty()) return;
    opening_.run(tree.nodes, opening);
    if (opening_.block_count() > WideChild::kFirstBlockMask) {
        throw Error(ErrorCode::unsupported, "the layout would have " + std::to_string(opening_.block_count()) +
                                                " blocks of triangles, and 2^28 - 1 is the most");
    }
    result.blocks.resize_for_overwrite(opening_.block_count());
    result.nodes.resize_for_overwrite(opening_.node_count());
    result.depth = opening_.depth();
    with_triangles(mesh, [&](const auto& triangles) {
        tbb::parallel_for(
            std::size_t{0}, opening_.pieces().size(),
            [&](std::size_t i) {
                const Piece<Width>& piece = opening_.pieces()[i];
                write_nodes(tree.nodes.data(), piece, i == 0, result.nodes.data());
                write_blocks(piece.blocks, tree.primitive_ids.data(), triangles,
                             result.blocks.data() + piece.first_block);
            },
            tbb::simple_partitioner{});
    });
}

template class WideConverter<4>;
template class WideConverter<8>;

namespace {

template <std::uint32_t Width>
void make(const Bvh& bvh, const MeshView& mesh, WideLayout<Width>& result, const LayoutOptions& options) {
    make_in_arena(result, options, [&] {
        if (options.check) check_tree(bvh, mesh);
        WideConverter<Width>().run(view_of(bvh), mesh, result, options.opening);
    });
}

}  // namespace
}  // namespace clbvh::layout

namespace clbvh {

void make_layout(const Bvh& bvh, const MeshView& mesh, Wide8& result, const LayoutOptions& options) {
    layout::make(bvh, mesh, result, options);
}

void make_layout(const Bvh& bvh, const MeshView& mesh, Wide4& result, const LayoutOptions& options) {
    layout::make(bvh, mesh, result, options);
}

}  // namespace clbvh
