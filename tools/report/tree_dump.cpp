#include "report/tree_dump.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <clbvh/core/error.hpp>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

namespace clbvh::tool {
namespace {

struct DumpedNode {
    std::uint32_t node;
    std::uint32_t depth;
};

/// Nodes of at most `most_depth` edges below the root, parents before children, first child first.
std::vector<DumpedNode> dumped_nodes(const Bvh& bvh, std::uint32_t most_depth) {
    std::vector<DumpedNode> visits, open;
    if (!bvh.empty()) open.push_back({0, 0});
    while (!open.empty()) {
        const DumpedNode visit = open.back();
        open.pop_back();
        visits.push_back(visit);
        const Node& node = bvh.nodes[visit.node];
        if (node.is_leaf() || visit.depth >= most_depth) continue;
        open.push_back({node.first + 1, visit.depth + 1});
        open.push_back({node.first, visit.depth + 1});
    }
    return visits;
}

std::string json_number(float value) {
    return std::isfinite(value) ? fmt::format("{}", value) : "null";
}

std::string json_point(const float (&point)[3]) {
    return fmt::format("[{}, {}, {}]", json_number(point[0]), json_number(point[1]), json_number(point[2]));
}

void append_node(const Bvh& bvh, const DumpedNode& visit, fmt::memory_buffer& text) {
    const auto out = std::back_inserter(text);
    const Node& node = bvh.nodes[visit.node];
    fmt::format_to(out, R"(    {{"node": {}, "depth": {}, "lower": {}, "upper": {}, )", visit.node, visit.depth,
                   json_point(node.lower), json_point(node.upper));
    if (node.is_leaf()) {
        const auto ids = bvh.primitive_ids.begin() + static_cast<std::ptrdiff_t>(node.first);
        fmt::format_to(out, R"("primitives": [{}]}})", fmt::join(ids, ids + node.count, ", "));
    } else {
        fmt::format_to(out, R"("children": [{}, {}]}})", node.first, node.first + 1);
    }
}

void append_box(const Node& node, std::size_t box, fmt::memory_buffer& text) {
    const auto out = std::back_inserter(text);
    // Bit k of a corner says on which side it is along axis k.
    for (std::size_t corner = 0; corner < 8; ++corner) {
        std::array<float, 3> point;
        for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = ((corner >> axis) & 1U) != 0 ? node.upper[axis] : node.lower[axis];
        fmt::format_to(out, "v {} {} {}\n", point[0], point[1], point[2]);
    }
    for (std::size_t corner = 0; corner < 8; ++corner) {
        for (std::size_t bit = 1; bit < 8; bit *= 2) {
            if ((corner & bit) == 0)
                fmt::format_to(out, "l {} {}\n", 8 * box + corner + 1, 8 * box + (corner | bit) + 1);
        }
    }
}

void require_finite(const Bvh& bvh, const DumpedNode& visit) {
    const Node& node = bvh.nodes[visit.node];
    const auto is_finite = [](float value) { return std::isfinite(value); };
    if (std::ranges::all_of(node.lower, is_finite) && std::ranges::all_of(node.upper, is_finite)) return;
    throw Error(ErrorCode::invalid_input,
                fmt::format("node {}: its box is not finite, which OBJ cannot hold; write JSON", visit.node));
}

}  // namespace

std::string tree_json(const Bvh& bvh, std::uint32_t most_depth) {
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text),
                   "{{\n  \"primitive_count\": {},\n  \"split_references\": {},\n  \"slots\": {},\n  \"nodes\": [",
                   bvh.primitive_count, bvh.split_references, bvh.nodes.size());
    const char* separator = "\n";
    for (const DumpedNode& visit : dumped_nodes(bvh, most_depth)) {
        fmt::format_to(std::back_inserter(text), "{}", separator);
        append_node(bvh, visit, text);
        separator = ",\n";
    }
    fmt::format_to(std::back_inserter(text), "{}]\n}}\n", bvh.empty() ? "" : "\n  ");
    return fmt::to_string(text);
}

std::string tree_obj(const Bvh& bvh, std::uint32_t most_depth) {
    std::vector<DumpedNode> visits = dumped_nodes(bvh, most_depth);
    std::ranges::stable_sort(visits, {}, &DumpedNode::depth);
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "# boxes of {} nodes\n", visits.size());
    for (std::size_t i = 0; i < visits.size(); ++i) {
        require_finite(bvh, visits[i]);
        if (i == 0 || visits[i].depth != visits[i - 1].depth)
            fmt::format_to(std::back_inserter(text), "g depth_{}\n", visits[i].depth);
        append_box(bvh.nodes[visits[i].node], i, text);
    }
    return fmt::to_string(text);
}

}  // namespace clbvh::tool
